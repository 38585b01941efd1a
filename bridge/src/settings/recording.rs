//! The settings of recordings and audits in folders.

use std::path::{Path, PathBuf};
use std::time::Duration;

use super::{Settings, SettingsError};
use crate::audit;
use crate::record::{Keep, MEBIBYTE, is_folder};

/// Greatest number for a recording: a tebibyte in MiB, or two years in minutes.
pub(super) const MOST: u64 = 1024 * 1024;

/// MiB of audits that are kept: some hundred thousand lines.
const AUDIT_BUDGET: u64 = 64;

/// The defaults of these settings, where they have an effect; a named file is a single piece that
/// grows.
pub(super) fn defaults(record: Option<&Path>, audit: Option<&Path>) -> Settings {
    let keep = record.is_some_and(is_folder).then(Keep::default);
    Settings {
        record_piece_mib: keep.map(|keep| keep.piece_bytes / MEBIBYTE),
        record_piece_minutes: keep.map(|keep| keep.piece_age.as_secs() / 60),
        record_budget_mib: keep.map(|keep| keep.all_bytes / MEBIBYTE),
        audit_budget_mib: audit.map(|_| AUDIT_BUDGET),
        ..Settings::default()
    }
}

impl Settings {
    /// How recordings in a folder are split into pieces, and how much is kept.
    #[must_use]
    pub fn keep(&self) -> Keep {
        let default = Keep::default();
        let bytes = |mib: Option<u64>, else_bytes: u64| {
            mib.map_or(else_bytes, |mib| mib.saturating_mul(MEBIBYTE))
        };
        let minutes = |minutes: u64| Duration::from_secs(minutes.saturating_mul(60));
        Keep {
            piece_bytes: bytes(self.record_piece_mib, default.piece_bytes),
            piece_age: self.record_piece_minutes.map_or(default.piece_age, minutes),
            all_bytes: bytes(self.record_budget_mib, default.all_bytes),
        }
    }

    /// Where the audit goes, and how much of it is kept.
    #[must_use]
    pub fn audit(&self) -> Option<(PathBuf, Keep)> {
        let budget = self.audit_budget_mib.unwrap_or(AUDIT_BUDGET);
        self.audit
            .clone()
            .map(|folder| (folder, audit::keep(budget)))
    }

    pub(super) fn check_recording(&self) -> Result<(), SettingsError> {
        let figures = [
            ("record-piece-mib", self.record_piece_mib),
            ("record-piece-minutes", self.record_piece_minutes),
            ("record-budget-mib", self.record_budget_mib),
            ("audit-budget-mib", self.audit_budget_mib),
        ];
        for (key, value) in figures {
            if let Some(value) = value.filter(|value| !(1..=MOST).contains(value)) {
                return Err(SettingsError::Recording { key, value });
            }
        }
        let idle = match self.record.as_deref() {
            None => Some("nothing is recorded; set `record` to a folder (a path that ends in /)"),
            Some(record) if !is_folder(record) => Some(
                "`record` names a file, which grows as long as the bridge runs; name a folder (a path that ends in /)",
            ),
            Some(_) => None,
        };
        let given = figures[..3].iter().find(|(_, value)| value.is_some());
        if let (Some(why), Some((key, _))) = (idle, given) {
            return Err(SettingsError::Idle { key, why });
        }
        if let (None, Some(_)) = (&self.audit, self.audit_budget_mib) {
            return Err(SettingsError::Idle {
                key: "audit-budget-mib",
                why: "no audit is written; set `audit` to a folder",
            });
        }
        let keep = self.keep();
        if keep.all_bytes < 2 * keep.piece_bytes {
            return Err(SettingsError::Budget {
                budget: keep.all_bytes / MEBIBYTE,
                piece: keep.piece_bytes / MEBIBYTE,
            });
        }
        Ok(())
    }
}

//! Uploads one piece to the store: part by part from where the upload was left, then compared.

use std::path::{Path, PathBuf};

use futures_util::TryStreamExt;
use object_store::multipart::{MultipartStore, PartId};
use object_store::{MultipartId, ObjectStoreExt, PutPayload};
use sha2::{Digest, Sha256};
use tokio::fs::File;
use tokio::io::{AsyncReadExt, AsyncSeekExt, SeekFrom};

use super::bucket::{Bucket, is_refusal, words};
use super::ledger::Ledger;
use crate::hexadecimal;

/// So many refusals in a row end an upload, and the next call begins another. A store that was
/// killed while it completed an upload may refuse that one for ever.
const MOST_REFUSALS: u32 = 3;

/// Why a piece is not stored yet.
#[derive(Debug, thiserror::Error)]
pub(super) enum Fault {
    /// Something is wrong with the store, or the connection to it.
    #[error("{}", words(.0))]
    Store(#[from] object_store::Error),
    /// The folder on this machine does not exist.
    #[error("the folder {} is not there; make it, or mount the disk that has it", .0.display())]
    NoFolder(PathBuf),
    /// The piece or its ledger cannot be read or written.
    #[error("{0}")]
    Disk(#[from] std::io::Error),
    /// The stored object differs: it is uploaded again.
    #[error(
        "what the store has of it is not what was sent ({found} of {expected}); it is sent again"
    )]
    Differs { found: String, expected: String },
}

/// Stores a piece, and returns its SHA-256.
///
/// # Errors    [`Fault`]; the ledger keeps which parts are stored, and the next call goes on from
/// there.
pub(super) async fn upload(
    piece: &Path,
    name: &str,
    bucket: &Bucket,
    ledger: &mut Ledger,
    verify: bool,
) -> Result<String, Fault> {
    if let Some(folder) = bucket.missing() {
        return Err(Fault::NoFolder(folder.to_owned()));
    }
    let sum = match &ledger.sum {
        Some(sum) => sum.clone(),
        None => {
            // An upload begun by an earlier version of this program has another name in the store.
            ledger.begin_anew();
            let sum = sum_of(piece).await?;
            ledger.sum = Some(sum.clone());
            ledger.write(piece)?;
            sum
        }
    };
    let name = &ledger.name_in_store(name);
    match &bucket.parts {
        Some(_) => in_parts(piece, name, bucket, ledger).await?,
        None => whole(piece, name, bucket, ledger.part_bytes).await?,
    }
    if verify {
        let found = sum_in(bucket, name).await?;
        if found != sum {
            // No stored part can be trusted.
            ledger.begin_anew();
            ledger.write(piece)?;
            let expected = sum;
            return Err(Fault::Differs { found, expected });
        }
    }
    ledger.stored = Some(sum.clone());
    (ledger.upload, ledger.parts) = (None, vec![]);
    ledger.write(piece)?;
    Ok(sum)
}

async fn in_parts(
    piece: &Path,
    name: &str,
    bucket: &Bucket,
    ledger: &mut Ledger,
) -> Result<(), Fault> {
    let Some(store) = &bucket.parts else {
        return Ok(());
    };
    let path = bucket.path(name);
    let id = match &ledger.upload {
        Some(id) => id.clone(),
        None => {
            let id = store.create_multipart(&path).await?;
            ledger.upload = Some(id.clone());
            ledger.write(piece)?;
            id
        }
    };
    let sent = send_parts(&**store, &path, &id, piece, ledger).await;
    if sent.is_err() && ledger.upload.is_none() {
        // Frees the room of its parts. A store that knows nothing of the upload refuses this, too.
        let _ = store.abort_multipart(&path, &id).await;
    }
    sent
}

/// Sends the parts that the store does not have yet, and has it join all of them.
async fn send_parts(
    store: &dyn MultipartStore,
    path: &object_store::path::Path,
    id: &MultipartId,
    piece: &Path,
    ledger: &mut Ledger,
) -> Result<(), Fault> {
    let mut file = File::open(piece).await?;
    let count = ledger.bytes.div_ceil(ledger.part_bytes);
    for index in ledger.parts.len() as u64..count {
        let begins = index * ledger.part_bytes;
        let bytes = ledger.part_bytes.min(ledger.bytes - begins);
        file.seek(SeekFrom::Start(begins)).await?;
        let mut part = vec![0; bytes as usize];
        file.read_exact(&mut part).await?;
        let put = store
            .put_part(path, id, index as usize, PutPayload::from(part))
            .await;
        let put = accepted(put, ledger, piece)?;
        ledger.parts.push(put.content_id);
        ledger.refusals = 0;
        ledger.write(piece)?;
    }
    let parts = ledger.parts.iter().cloned();
    let parts = parts.map(|content_id| PartId { content_id }).collect();
    let done = store.complete_multipart(path, id, parts).await;
    accepted(done, ledger, piece).map(|_| ())
}

/// Passes the store's answer on. If the store does not know the upload any more, because it is
/// already complete or was cleaned up, or keeps refusing it, the next call sends the piece from the
/// start.
fn accepted<T>(
    answer: object_store::Result<T>,
    ledger: &mut Ledger,
    piece: &Path,
) -> Result<T, Fault> {
    let is_over = match &answer {
        Err(object_store::Error::NotFound { .. }) => true,
        Err(error) if is_refusal(error) => {
            ledger.refusals += 1;
            ledger.refusals >= MOST_REFUSALS
        }
        _ => return Ok(answer?),
    };
    if is_over {
        ledger.begin_anew();
    }
    ledger.write(piece)?;
    Ok(answer?)
}

/// For a store without uploads that can be continued; the object gets its name only at the end.
async fn whole(piece: &Path, name: &str, bucket: &Bucket, part_bytes: u64) -> Result<(), Fault> {
    let mut upload = bucket.store.put_multipart(&bucket.path(name)).await?;
    let mut file = File::open(piece).await?;
    loop {
        let mut part = vec![];
        (&mut file).take(part_bytes).read_to_end(&mut part).await?;
        if part.is_empty() {
            break;
        }
        upload.put_part(PutPayload::from(part)).await?;
    }
    upload.complete().await?;
    Ok(())
}

async fn sum_of(piece: &Path) -> Result<String, Fault> {
    let mut file = File::open(piece).await?;
    let (mut sum, mut buffer) = (Sha256::new(), vec![0; 1 << 16]);
    loop {
        let count = file.read(&mut buffer).await?;
        match buffer.get(..count).filter(|read| !read.is_empty()) {
            Some(read) => sum.update(read),
            None => break,
        }
    }
    Ok(hexadecimal::write(&sum.finalize()))
}

async fn sum_in(bucket: &Bucket, name: &str) -> Result<String, Fault> {
    let found = bucket.store.get(&bucket.path(name)).await?;
    let mut bytes = found.into_stream();
    let mut sum = Sha256::new();
    while let Some(read) = bytes.try_next().await? {
        sum.update(&read);
    }
    Ok(hexadecimal::write(&sum.finalize()))
}

#[cfg(test)]
mod tests {
    use std::fs;
    use std::sync::Arc;
    use std::sync::atomic::{AtomicUsize, Ordering};

    use async_trait::async_trait;
    use object_store::memory::InMemory;
    use object_store::{Error, PutResult};

    use super::*;
    use crate::storage::StorageConfig;

    const PIECE: &str = "slamlab-2026-01-01T00-00-00Z.mcap";

    fn bucket(folder: &Path) -> Bucket {
        let url = format!("file://{}", folder.display());
        Bucket::open(&StorageConfig::new(url)).unwrap()
    }

    /// A robot that stores what it recorded.
    async fn store(bucket: &Bucket, bytes: &[u8]) -> Ledger {
        let robot = tempfile::tempdir().unwrap();
        let piece = robot.path().join(PIECE);
        fs::write(&piece, bytes).unwrap();
        let mut ledger = Ledger::of(&piece, &bucket.url, bytes.len() as u64, 5);
        upload(&piece, PIECE, bucket, &mut ledger, true)
            .await
            .unwrap();
        ledger
    }

    #[tokio::test]
    async fn robots_that_began_in_one_second_do_not_write_over_each_other() {
        let kept = tempfile::tempdir().unwrap();
        let bucket = bucket(kept.path());
        let of_before = kept.path().join(PIECE);
        fs::write(&of_before, "of a program before").unwrap();
        let robots = [b"the first robot's".as_slice(), b"the second robot's"];
        let mut names = vec![];
        for bytes in robots {
            let ledger = store(&bucket, bytes).await;
            let name = ledger.name_in_store(PIECE);
            assert!(crate::record::is_piece_in_store(&name), "{name}");
            names.push(name);
        }
        for (name, bytes) in names.iter().zip(robots) {
            assert_eq!(fs::read(kept.path().join(name)).unwrap(), bytes);
        }
        assert_eq!(fs::read(of_before).unwrap(), b"of a program before");
        // A robot that lost its ledger stores nothing twice.
        store(&bucket, robots[0]).await;
        assert_eq!(fs::read_dir(kept.path()).unwrap().count(), 3);
    }

    #[tokio::test]
    async fn a_folder_that_is_not_there_is_said_and_not_made() {
        let (root, robot) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
        let folder = root.path().join("nas/drives");
        let bucket = bucket(&folder);
        let piece = robot.path().join(PIECE);
        fs::write(&piece, "a piece").unwrap();
        let mut ledger = Ledger::of(&piece, &bucket.url, 7, 5);
        let error = upload(&piece, PIECE, &bucket, &mut ledger, true)
            .await
            .unwrap_err();
        let expected = format!("the folder {} is not there", folder.display());
        assert!(error.to_string().contains(&expected), "{error}");
        assert_eq!(fs::read_dir(root.path()).unwrap().count(), 0);
    }

    #[tokio::test]
    async fn what_a_program_before_had_begun_is_sent_anew_and_what_it_stored_keeps_its_name() {
        let (kept, robot) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
        let bucket = bucket(kept.path());
        let piece = robot.path().join(PIECE);
        fs::write(&piece, "a piece").unwrap();
        let mut ledger = Ledger {
            upload: Some("7".into()),
            parts: vec!["x".into()],
            ..Ledger::of(&piece, &bucket.url, 7, 5)
        };
        let sum = upload(&piece, PIECE, &bucket, &mut ledger, true)
            .await
            .unwrap();
        assert_eq!(
            (&ledger.stored, &ledger.sum),
            (&Some(sum.clone()), &Some(sum))
        );
        assert_eq!(Ledger::read(&piece), Some(ledger.clone()));
        ledger.sum = None;
        assert_eq!(ledger.name_in_store(PIECE), PIECE);
    }
    /// A store whose first uploads cannot be completed.
    #[derive(Debug)]
    struct Refusing {
        store: InMemory,
        /// So many uploads, and with which error.
        first: usize,
        error: fn() -> Error,
        begun: AtomicUsize,
        aborted: AtomicUsize,
    }

    fn denied() -> Error {
        Error::PermissionDenied {
            path: PIECE.into(),
            source: "403 Forbidden".into(),
        }
    }

    fn full() -> Error {
        Error::Generic {
            store: "S3",
            source: "Server returned non-2xx status code: 400 Bad Request: QuotaExceeded".into(),
        }
    }

    fn gone() -> Error {
        Error::Generic {
            store: "S3",
            source: "Connection refused (os error 111)".into(),
        }
    }

    #[async_trait]
    impl MultipartStore for Refusing {
        async fn create_multipart(
            &self,
            path: &object_store::path::Path,
        ) -> object_store::Result<MultipartId> {
            self.begun.fetch_add(1, Ordering::Relaxed);
            self.store.create_multipart(path).await
        }

        async fn put_part(
            &self,
            path: &object_store::path::Path,
            id: &MultipartId,
            part_idx: usize,
            data: PutPayload,
        ) -> object_store::Result<PartId> {
            self.store.put_part(path, id, part_idx, data).await
        }

        async fn complete_multipart(
            &self,
            path: &object_store::path::Path,
            id: &MultipartId,
            parts: Vec<PartId>,
        ) -> object_store::Result<PutResult> {
            match self.begun.load(Ordering::Relaxed) <= self.first {
                true => Err((self.error)()),
                false => self.store.complete_multipart(path, id, parts).await,
            }
        }

        async fn abort_multipart(
            &self,
            path: &object_store::path::Path,
            id: &MultipartId,
        ) -> object_store::Result<()> {
            self.aborted.fetch_add(1, Ordering::Relaxed);
            self.store.abort_multipart(path, id).await
        }
    }

    /// What came of so many tries, one after the other, each with the ledger that the one before
    /// has left: whether the last one stored the piece, how many uploads it took, and how many were
    /// aborted.
    async fn tries(first: usize, error: fn() -> Error, count: usize) -> (bool, usize, usize) {
        let (kept, robot) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
        let store = Arc::new(Refusing {
            store: InMemory::new(),
            first,
            error,
            begun: AtomicUsize::new(0),
            aborted: AtomicUsize::new(0),
        });
        let mut bucket = bucket(kept.path());
        bucket.parts = Some(store.clone());
        let piece = robot.path().join(PIECE);
        fs::write(&piece, "a piece of two parts").unwrap();
        let mut is_stored = false;
        for _ in 0..count {
            let mut ledger = Ledger::of(&piece, &bucket.url, 20, 10);
            is_stored = upload(&piece, PIECE, &bucket, &mut ledger, false)
                .await
                .is_ok();
        }
        let (begun, aborted) = (&store.begun, &store.aborted);
        (
            is_stored,
            begun.load(Ordering::Relaxed),
            aborted.load(Ordering::Relaxed),
        )
    }

    #[tokio::test]
    async fn an_upload_that_the_store_keeps_refusing_is_given_up_for_another() {
        let most = MOST_REFUSALS as usize;
        assert_eq!(tries(1, denied, most).await, (false, 1, 1));
        assert_eq!(tries(1, denied, most + 1).await, (true, 2, 1));
        assert_eq!(tries(2, denied, 2 * most + 1).await, (true, 3, 2));
    }

    #[tokio::test]
    async fn an_upload_waits_for_room_and_for_the_connection() {
        assert_eq!(tries(1, full, 20).await, (false, 1, 0));
        assert_eq!(tries(1, gone, 20).await, (false, 1, 0));
    }
}

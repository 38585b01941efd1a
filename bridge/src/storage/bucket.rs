//! The store at a URL, and what of it went wrong in words.

use std::sync::Arc;
use std::time::Duration;

use object_store::aws::AmazonS3Builder;
use object_store::azure::MicrosoftAzureBuilder;
use object_store::gcp::GoogleCloudStorageBuilder;
use object_store::local::LocalFileSystem;
use object_store::multipart::MultipartStore;
use object_store::path::Path;
use object_store::{ClientOptions, Error, ObjectStore, ObjectStoreScheme, RetryConfig};
use url::Url;

use super::{StorageConfig, StorageError};

/// A request that got no answer for so long is tried again: the link is broken.
const SILENT: Duration = Duration::from_secs(30);
const CONNECT: Duration = Duration::from_secs(10);

/// A store, and the folder in it.
#[derive(Clone)]
pub(super) struct Bucket {
    pub(super) store: Arc<dyn ObjectStore>,
    /// By which uploads go on; a folder of this machine needs none.
    pub(super) parts: Option<Arc<dyn MultipartStore>>,
    folder: Path,
    pub(super) url: String,
}

impl std::fmt::Debug for Bucket {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Bucket").field("url", &self.url).finish()
    }
}

/// A builder with the options of environment and settings; the latter must be known to it.
macro_rules! with_options {
    ($builder:expr, $config:expr, $prefix:literal) => {{
        let mut builder = $builder.with_url(&$config.url);
        for (key, value) in std::env::vars_os() {
            let (Some(key), Some(value)) = (key.to_str(), value.to_str()) else {
                continue;
            };
            if let (true, Ok(key)) = (key.starts_with($prefix), key.to_ascii_lowercase().parse()) {
                builder = builder.with_config(key, value);
            }
        }
        for (key, value) in &$config.options {
            let known = key.parse().map_err(|error: Error| StorageError::Option {
                url: $config.url.clone(),
                key: key.clone(),
                why: words(&error),
            })?;
            builder = builder.with_config(known, value);
        }
        builder.with_retry(retry())
    }};
}

impl Bucket {
    /// Nothing is asked of it yet: a network that is not there is no reason not to start.
    ///
    /// # Errors    [`StorageError`].
    pub(super) fn open(config: &StorageConfig) -> Result<Self, StorageError> {
        let wrong = |why: String| StorageError::Url {
            url: config.url.clone(),
            why,
        };
        let unfit = |error: Error| StorageError::Store {
            url: config.url.clone(),
            why: words(&error),
        };
        let url: Url =
            (config.url.parse()).map_err(|error: url::ParseError| wrong(error.to_string()))?;
        let (scheme, folder) =
            ObjectStoreScheme::parse(&url).map_err(|error| wrong(error.to_string()))?;
        let (store, parts): (Arc<dyn ObjectStore>, Option<Arc<dyn MultipartStore>>) = match scheme {
            ObjectStoreScheme::Local => (Arc::new(LocalFileSystem::new()), None),
            ObjectStoreScheme::AmazonS3 => {
                let builder = with_options!(AmazonS3Builder::new(), config, "AWS_");
                // What the settings say of clear HTTP is for the endpoint, which they name.
                let store = Arc::new(builder.build().map_err(unfit)?);
                (store.clone(), Some(store))
            }
            ObjectStoreScheme::GoogleCloudStorage => {
                let builder = with_options!(GoogleCloudStorageBuilder::new(), config, "GOOGLE_");
                let builder = builder.with_client_options(patience());
                let store = Arc::new(builder.build().map_err(unfit)?);
                (store.clone(), Some(store))
            }
            ObjectStoreScheme::MicrosoftAzure => {
                let builder = with_options!(MicrosoftAzureBuilder::new(), config, "AZURE_");
                let store = Arc::new(builder.build().map_err(unfit)?);
                (store.clone(), Some(store))
            }
            other => return Err(wrong(format!("{other:?} is no store for recordings"))),
        };
        Ok(Self {
            store,
            parts,
            folder,
            url: config.url.trim_end_matches('/').to_owned(),
        })
    }

    /// Where a file is kept in it.
    pub(super) fn path(&self, name: &str) -> Path {
        self.folder.clone().join(name)
    }

    /// Where files are.
    pub(super) fn folder(&self) -> &Path {
        &self.folder
    }
}

/// The uploader tries again by itself, and says so: here it is only for a hiccup.
fn retry() -> RetryConfig {
    RetryConfig {
        max_retries: 1,
        retry_timeout: Duration::from_secs(20),
        ..RetryConfig::default()
    }
}

fn patience() -> ClientOptions {
    ClientOptions::new()
        .with_timeout(SILENT)
        .with_connect_timeout(CONNECT)
}

/// What a person reads: what is wrong, and what helps.
pub(super) fn words(error: &Error) -> String {
    match error {
        Error::NotFound { .. } => format!(
            "the bucket, or something in it, is not there ({})",
            root(error)
        ),
        Error::PermissionDenied { .. } => format!(
            "the store denies it; look at the rights of its key ({})",
            root(error)
        ),
        Error::Unauthenticated { .. } => format!(
            "the store does not know the key; look at it ({})",
            root(error)
        ),
        other => {
            let root = root(other);
            let text = other.to_string();
            match [
                "QuotaExceeded",
                "507",
                "InsufficientStorage",
                "EntityTooLarge",
                "XMinioStorageFull",
                "No space left",
            ]
            .iter()
            .any(|full| text.contains(full))
            {
                true => format!("the bucket is full ({root})"),
                false => root,
            }
        }
    }
}

/// The cause of the causes: the rest says it in more words.
fn root(error: &Error) -> String {
    let mut at: &dyn std::error::Error = error;
    while let Some(cause) = at.source() {
        at = cause;
    }
    let text = at.to_string();
    let line = text.split_whitespace().collect::<Vec<_>>().join(" ");
    match line.char_indices().nth(300) {
        Some((end, _)) => format!("{}…", line.get(..end).unwrap_or_default()),
        None => line,
    }
}

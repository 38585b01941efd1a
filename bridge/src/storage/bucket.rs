//! The store at a URL, and its errors in words.

use std::path::PathBuf;
use std::sync::Arc;
use std::time::Duration;

use object_store::aws::{AmazonS3Builder, AmazonS3ConfigKey};
use object_store::azure::{AzureConfigKey, MicrosoftAzureBuilder};
use object_store::gcp::{GoogleCloudStorageBuilder, GoogleConfigKey};
use object_store::local::LocalFileSystem;
use object_store::multipart::MultipartStore;
use object_store::path::Path;
use object_store::{ClientOptions, Error, ObjectStore, ObjectStoreScheme, RetryConfig};
use url::Url;

use super::{StorageConfig, StorageError};
use crate::record::is_folder;

/// A request without an answer for this long is tried again: the link is broken.
const SILENT: Duration = Duration::from_secs(30);
const CONNECT: Duration = Duration::from_secs(10);

/// A store, and the folder in it.
#[derive(Clone)]
pub(super) struct Bucket {
    pub(super) store: Arc<dyn ObjectStore>,
    /// For uploads that can be continued; a folder of this machine needs none.
    pub(super) parts: Option<Arc<dyn MultipartStore>>,
    folder: Path,
    pub(super) url: String,
    /// The store's endpoint, if it is not given by the URL alone.
    endpoint: Option<String>,
    /// The folder, if the store is one on this machine.
    local: Option<PathBuf>,
}

/// Which store and where, for people who have to look there.
impl std::fmt::Display for Bucket {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(&self.url)?;
        match &self.endpoint {
            Some(endpoint) => write!(f, " at {endpoint}"),
            None => Ok(()),
        }
    }
}

impl std::fmt::Debug for Bucket {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Bucket").field("url", &self.url).finish()
    }
}

/// A builder with the options of environment and settings; it must know those of the settings.
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
    /// Opens the store, without any request: a missing network must not prevent the start.
    ///
    /// # Errors    [`StorageError`].
    pub(super) fn open(config: &StorageConfig) -> Result<Self, StorageError> {
        // The store's client uses the process-wide provider; on a second start it is already
        // installed.
        let _ = tokio_rustls::rustls::crypto::ring::default_provider().install_default();
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
        let (mut endpoint, mut local) = (None, None);
        let (store, parts): (Arc<dyn ObjectStore>, Option<Arc<dyn MultipartStore>>) = match scheme {
            ObjectStoreScheme::Local => {
                let path = url.to_file_path();
                local = Some(path.map_err(|()| wrong("it names no folder".to_owned()))?);
                (Arc::new(LocalFileSystem::new()), None)
            }
            ObjectStoreScheme::AmazonS3 => {
                let builder = with_options!(AmazonS3Builder::new(), config, "AWS_");
                endpoint = builder
                    .get_config_value(&AmazonS3ConfigKey::S3Endpoint)
                    .or_else(|| builder.get_config_value(&AmazonS3ConfigKey::Endpoint));
                check_endpoint(config, endpoint.as_deref(), "aws_endpoint")?;
                // Whether plain HTTP is allowed is up to the settings, which also name the
                // endpoint.
                let store = Arc::new(builder.build().map_err(unfit)?);
                (store.clone(), Some(store))
            }
            ObjectStoreScheme::GoogleCloudStorage => {
                let builder = with_options!(GoogleCloudStorageBuilder::new(), config, "GOOGLE_");
                endpoint = builder.get_config_value(&GoogleConfigKey::BaseUrl);
                check_endpoint(config, endpoint.as_deref(), "google_base_url")?;
                let builder = builder.with_client_options(patience());
                let store = Arc::new(builder.build().map_err(unfit)?);
                (store.clone(), Some(store))
            }
            ObjectStoreScheme::MicrosoftAzure => {
                let builder = with_options!(MicrosoftAzureBuilder::new(), config, "AZURE_");
                endpoint = builder.get_config_value(&AzureConfigKey::Endpoint);
                check_endpoint(config, endpoint.as_deref(), "azure_storage_endpoint")?;
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
            endpoint,
            local,
        })
    }

    /// Whether it is a folder that is, contains, or lies in the folder of the recording.
    pub(super) fn meets(&self, record: Option<&std::path::Path>) -> bool {
        let record = record.filter(|path| is_folder(path));
        let (Some(local), Some(record)) = (&self.local, record) else {
            return false;
        };
        let (local, record) = (found(local), found(record));
        local.starts_with(&record) || record.starts_with(&local)
    }

    /// The folder of this machine, if it is missing. It is not created, because a disk may have to
    /// be mounted there.
    pub(super) fn missing(&self) -> Option<&std::path::Path> {
        self.local.as_deref().filter(|path| !path.is_dir())
    }

    /// The path of a file in the store.
    pub(super) fn path(&self, name: &str) -> Path {
        self.folder.clone().join(name)
    }

    /// The folder of the files in the store.
    pub(super) fn folder(&self) -> &Path {
        &self.folder
    }
}

/// The canonical path, even if the last of its folders do not exist yet.
fn found(path: &std::path::Path) -> PathBuf {
    let path = std::path::absolute(path).unwrap_or_else(|_| path.to_owned());
    let there = path.ancestors().find_map(|above| {
        let rest = path.strip_prefix(above).ok()?;
        Some(above.canonicalize().ok()?.join(rest))
    });
    there.unwrap_or(path)
}

/// Checks that the store's endpoint is an address, and one that everybody may see.
fn check_endpoint(
    config: &StorageConfig,
    endpoint: Option<&str>,
    usual_key: &str,
) -> Result<(), StorageError> {
    let Some(endpoint) = endpoint else {
        return Ok(());
    };
    let why = match endpoint.parse::<Url>() {
        Ok(url) if !url.username().is_empty() || url.password().is_some() => {
            "it holds a user or a password, and whoever watches would see it".to_owned()
        }
        Ok(url) if url.has_host() && ["http", "https"].contains(&url.scheme()) => return Ok(()),
        _ => format!("{endpoint:?} is no address; expected https:// or http:// and a host"),
    };
    // The endpoint may also come from the environment.
    let given = config.options.iter().find(|(_, value)| *value == endpoint);
    Err(StorageError::Option {
        url: config.url.clone(),
        key: given.map_or(usual_key, |(key, _)| key).to_owned(),
        why,
    })
}

/// One retry, for a hiccup only: the uploader retries by itself, and reports it.
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

/// Error codes of S3, Azure and Google, and of servers compatible with S3.
const NO_BUCKET: [&str; 2] = ["NoSuchBucket", "ContainerNotFound"];
const DENIED: [&str; 4] = [
    "SignatureDoesNotMatch",
    "InvalidAccessKeyId",
    "AccessDenied",
    "403 Forbidden",
];
const FULL: [&str; 6] = [
    "QuotaExceeded",
    "507",
    "InsufficientStorage",
    "EntityTooLarge",
    "XMinioStorageFull",
    "No space left",
];

/// The error for people: what is wrong, and what helps.
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
            match () {
                () if names(&text, &NO_BUCKET) => format!("the bucket is not there ({root})"),
                () if names(&text, &DENIED) => format!("the store does not take its key ({root})"),
                () if names(&text, &FULL) => format!("the bucket is full ({root})"),
                () => root,
            }
        }
    }
}

/// Whether the store itself said no, for another reason than a lack of room, to what it knows: the
/// connection works.
pub(super) fn is_refusal(error: &Error) -> bool {
    match error {
        Error::PermissionDenied { .. } | Error::Unauthenticated { .. } => true,
        other => {
            let text = other.to_string();
            text.contains("status code: 4") && !names(&text, &FULL)
        }
    }
}

/// Whether the text names one of these codes.
fn names(text: &str, codes: &[&str]) -> bool {
    codes.iter().any(|code| text.contains(code))
}

/// The root cause: the rest of the chain only repeats it in more words.
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

#[cfg(test)]
mod tests {
    use super::*;

    fn open(url: &str, options: &[(&str, &str)]) -> Result<Bucket, String> {
        let options = options.iter();
        let options = options.map(|(key, value)| ((*key).to_owned(), (*value).to_owned()));
        let config = StorageConfig {
            options: options.collect(),
            ..StorageConfig::new(url.to_owned())
        };
        Bucket::open(&config).map_err(|error| error.to_string())
    }

    #[test]
    fn an_endpoint_is_an_address_and_named_where_something_is_wrong() {
        let at = |endpoint| open("s3://b/k", &[("aws_endpoint", endpoint)]);
        let bucket = at("http://127.0.0.1:9").unwrap();
        assert_eq!(bucket.to_string(), "s3://b/k at http://127.0.0.1:9");
        for wrong in ["nonsense", "", "https://", "s3.example:9000", "file:///x"] {
            let error = at(wrong).unwrap_err();
            assert!(error.contains("options aws_endpoint"), "{error}");
            assert!(error.contains("is no address"), "{error}");
        }
        let error = at("https://me:hidden@s3.example").unwrap_err();
        assert!(error.contains("aws_endpoint: it holds"), "{error}");
        assert!(!error.contains("hidden"), "{error}");
    }

    #[cfg(unix)]
    #[test]
    fn a_store_that_is_the_folder_of_the_recording_is_found_by_any_way_there() {
        let root = tempfile::tempdir().unwrap();
        let at = |name: &str| root.path().join(name);
        std::fs::create_dir(at("drives")).unwrap();
        std::os::unix::fs::symlink(at("drives"), at("link")).unwrap();
        let meets = |store: &str, record: &str| {
            let url = format!("file://{}", at(store).display());
            open(&url, &[]).unwrap().meets(Some(&at(record)))
        };
        assert!(meets("drives", "drives/"));
        assert!(meets("link", "drives"));
        assert!(meets("drives/stored/here", "link/"));
        assert!(meets("not%20yet", "not yet/of/today/"));
        assert!(!meets("drives", "drives-2/"));
        assert!(!meets("kept", "drives/"));
        // A named file has no budget.
        assert!(!meets("drives", "drives/a.mcap"));
        assert!(!open("s3://drives", &[]).unwrap().meets(Some(&at("drives"))));
    }
}

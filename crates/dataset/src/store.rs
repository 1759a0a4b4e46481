//! Objects in a folder or a cloud.
//!
//! Clouds take their credentials from the environment, by the names that their own tools use: `AWS_ACCESS_KEY_ID`,
//! `AWS_REGION`, `AWS_ENDPOINT`, `GOOGLE_SERVICE_ACCOUNT`, `AZURE_STORAGE_ACCOUNT_NAME` and so on.

use crate::error::Error;
use futures_util::TryStreamExt;
use object_store::local::LocalFileSystem;
use object_store::path::Path;
use object_store::{ObjectStore, ObjectStoreExt, PutMode, PutOptions, WriteMultipart};
use std::io;
use std::path::PathBuf;
use std::sync::Arc;
use tokio::runtime::{Builder, Runtime};

/// What may be given as a place.
const KNOWN: &str = if cfg!(feature = "cloud") {
    "s3://BUCKET/PATH, gs://BUCKET/PATH or az://CONTAINER/PATH"
} else {
    "or build the program with the feature `cloud`: cargo build --release --features cloud"
};
/// Uploads of a large object that may be under way at a time.
const UPLOADS: usize = 4;

/// A folder, or a part of a cloud's bucket.
pub struct Store {
    objects: Arc<dyn ObjectStore>,
    root: Path,
    place: String,
    local: bool,
    runtime: Runtime,
}

/// An object that is there.
pub struct Object {
    /// Its name below the place.
    pub name: String,
    /// Its bytes.
    pub size: u64,
    /// When it was written, s since 1970.
    pub time: f64,
}

impl Store {
    /// Opens a place; `make`: a folder that is missing is made.
    pub fn open(place: &str, make: bool) -> Result<Self, Error> {
        let refused = |reason: String| Error::Place { place: place.to_owned(), reason, known: KNOWN };
        let system =
            |what: &'static str| move |source| Error::System { place: place.to_owned(), what: what.to_owned(), source };
        let runtime = Builder::new_current_thread().enable_all().build().map_err(system("begin"))?;
        let url = place.contains("://").then(|| url::Url::parse(place));
        let url = url.transpose().map_err(|error| refused(format!("it is no URL ({error})")))?;
        let folder = match &url {
            None => PathBuf::from(place),
            Some(url) if url.scheme() == "file" => {
                url.to_file_path().map_err(|()| refused("it names no folder of this machine".to_owned()))?
            }
            Some(url) => {
                let (objects, root) = cloud(url).map_err(refused)?;
                return Ok(Self { objects, root, place: place.to_owned(), local: false, runtime });
            }
        };
        if make {
            std::fs::create_dir_all(&folder).map_err(system("make the folder"))?;
        } else if !folder.is_dir() {
            return Err(Error::NoSweep { place: place.to_owned() });
        }
        let objects = LocalFileSystem::new_with_prefix(&folder).map_err(|error| refused(error.to_string()))?;
        // Parts survive a power cut.
        let objects: Arc<dyn ObjectStore> = Arc::new(objects.with_fsync(true));
        Ok(Self { objects, root: Path::default(), place: place.to_owned(), local: true, runtime })
    }

    /// The place as it was given.
    pub fn place(&self) -> &str {
        &self.place
    }

    fn path(&self, name: &str) -> Path {
        name.split('/').fold(self.root.clone(), |path, part| path.join(part))
    }

    fn failed(&self, what: impl Into<String>) -> impl FnOnce(object_store::Error) -> Error {
        use object_store::Error::{PermissionDenied, Unauthenticated};
        let (place, what, local) = (self.place.clone(), what.into(), self.local);
        move |error| {
            let denied = matches!(error, PermissionDenied { .. } | Unauthenticated { .. }) || is_denied(&error);
            let source = Box::new(error);
            match (denied, local) {
                (false, _) => Error::Store { place, what, source },
                (true, true) => Error::Denied { place, what, source, help: "give a folder that you may write to" },
                (true, false) => {
                    let help = "set the credentials of this store in the environment (AWS_…, GOOGLE_…, AZURE_…)";
                    Error::Denied { place, what, source, help }
                }
            }
        }
    }

    /// Creates an object; `false`: there is one of this name, which stays.
    pub fn create(&self, name: &str, bytes: Vec<u8>) -> Result<bool, Error> {
        let path = self.path(name);
        let create = PutOptions { mode: PutMode::Create, ..PutOptions::default() };
        match self.runtime.block_on(self.objects.put_opts(&path, bytes.into(), create)) {
            Ok(_) => Ok(true),
            Err(object_store::Error::AlreadyExists { .. }) => Ok(false),
            Err(error) => Err(self.failed(format!("write {name}"))(error)),
        }
    }

    /// Whether there is an object of this name.
    pub fn has(&self, name: &str) -> Result<bool, Error> {
        match self.runtime.block_on(self.objects.head(&self.path(name))) {
            Ok(_) => Ok(true),
            Err(object_store::Error::NotFound { .. }) => Ok(false),
            Err(error) => Err(self.failed(format!("look for {name}"))(error)),
        }
    }

    /// The bytes of an object; `None`: there is none of this name.
    pub fn read(&self, name: &str) -> Result<Option<Vec<u8>>, Error> {
        let path = self.path(name);
        let read = async { self.objects.get(&path).await?.bytes().await };
        match self.runtime.block_on(read) {
            Ok(bytes) => Ok(Some(bytes.into())),
            Err(object_store::Error::NotFound { .. }) => Ok(None),
            Err(error) => Err(self.failed(format!("read {name}"))(error)),
        }
    }

    /// The last bytes of an object.
    pub fn tail(&self, object: &Object, bytes: u64) -> Result<Vec<u8>, Error> {
        let path = self.path(&object.name);
        let range = object.size.saturating_sub(bytes)..object.size;
        let read = self.runtime.block_on(self.objects.get_range(&path, range));
        Ok(read.map_err(self.failed(format!("read {}", object.name)))?.into())
    }

    /// All objects.
    pub fn list(&self) -> Result<Vec<Object>, Error> {
        let root = (!self.local).then_some(&self.root);
        let all = self.runtime.block_on(self.objects.list(root).try_collect::<Vec<_>>());
        let all = all.map_err(self.failed("list its parts"))?;
        let object = |meta: object_store::ObjectMeta| {
            let parts: Vec<_> = meta.location.prefix_match(&self.root)?.collect();
            let name = parts.iter().map(AsRef::as_ref).collect::<Vec<&str>>().join("/");
            Some(Object { name, size: meta.size, time: meta.last_modified.timestamp_millis() as f64 / 1e3 })
        };
        Ok(all.into_iter().filter_map(object).collect())
    }

    /// Writes an object piece by piece. It appears whole, in place of one of this name, or not at all.
    pub fn write(&self, name: &str, content: impl FnOnce(&mut Upload<'_>) -> Result<(), Error>) -> Result<(), Error> {
        let path = self.path(name);
        let begun =
            self.runtime.block_on(self.objects.put_multipart(&path)).map_err(self.failed(format!("write {name}")))?;
        let mut upload = Upload { pieces: Some(WriteMultipart::new(begun)), runtime: &self.runtime };
        let outcome = content(&mut upload);
        let Some(pieces) = upload.pieces.take() else { return outcome };
        match outcome {
            Ok(()) => self.runtime.block_on(pieces.finish()).map(|_| ()).map_err(self.failed(format!("write {name}"))),
            Err(error) => {
                // The first failure is reported.
                let _ = self.runtime.block_on(pieces.abort());
                Err(error)
            }
        }
    }
}

/// An object that is being written.
pub struct Upload<'r> {
    pieces: Option<WriteMultipart>,
    runtime: &'r Runtime,
}

impl io::Write for Upload<'_> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let Some(pieces) = &mut self.pieces else { return Err(io::ErrorKind::BrokenPipe.into()) };
        self.runtime.block_on(async {
            pieces.wait_for_capacity(UPLOADS).await.map_err(io::Error::other)?;
            pieces.write(bytes);
            Ok(bytes.len())
        })
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

/// Whether the system denies access to a file, which the store of folders reports as one of many failures.
fn is_denied(error: &object_store::Error) -> bool {
    let mut cause: Option<&dyn std::error::Error> = Some(error);
    while let Some(error) = cause {
        if error.downcast_ref::<io::Error>().is_some_and(|error| error.kind() == io::ErrorKind::PermissionDenied) {
            return true;
        }
        cause = error.source();
    }
    false
}

/// The store at a URL.
#[cfg(feature = "cloud")]
fn cloud(url: &url::Url) -> Result<(Arc<dyn ObjectStore>, Path), String> {
    const SCHEMES: [&str; 6] = ["s3", "s3a", "gs", "az", "abfs", "abfss"];
    if !SCHEMES.contains(&url.scheme()) {
        return Err(format!("{}:// is no store", url.scheme()));
    }
    // Another part of the program may have chosen the same.
    let _ = rustls::crypto::ring::default_provider().install_default();
    let words =
        std::env::vars_os().filter_map(|(name, value)| Some((name.into_string().ok()?, value.into_string().ok()?)));
    let (objects, root) = object_store::parse_url_opts(url, words).map_err(|error| error.to_string())?;
    Ok((objects.into(), root))
}

/// Without the feature `cloud` there is none.
#[cfg(not(feature = "cloud"))]
fn cloud(url: &url::Url) -> Result<(Arc<dyn ObjectStore>, Path), String> {
    Err(format!("this program is built without {}:// and other clouds", url.scheme()))
}

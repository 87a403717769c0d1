//! Arrays of a `.npz` archive, checked before anything is made of them.
use anyhow::{Context, bail, ensure};
use npyz::npz::{NpzArchive, NpzWriter};
use npyz::zip::{CompressionMethod, DateTime, write::FileOptions};
use npyz::{AutoSerialize, Deserialize, NpyFile, Order, WriterBuilder};
use std::fs::File;
use std::io::{BufReader, Cursor, Read, Write};
use std::path::{Path, PathBuf};

/// An open archive.
pub(super) struct Arrays {
    path: PathBuf,
    archive: NpzArchive<BufReader<File>>,
}

impl Arrays {
    /// Opens the archive at `path`.
    ///
    /// # Errors
    /// When there is no such file, or it is not a whole zip archive.
    pub(super) fn open(path: &Path) -> anyhow::Result<Self> {
        let archive = NpzArchive::open(path).with_context(|| {
            let what = if path.exists() { "is truncated or not a .npz file" } else { "is missing" };
            format!("{} {what}; make it again", path.display())
        })?;
        Ok(Self { path: path.to_owned(), archive })
    }

    /// Whether there is an array `name`.
    pub(super) fn has(&mut self, name: &str) -> bool {
        self.archive.zip_archive().file_names().any(|there| there.strip_suffix(".npy") == Some(name))
    }

    /// The array `name` in row-major order, with as many axes as `shape`; a `None` there takes any length.
    ///
    /// # Errors
    /// When it is missing, damaged, of another element type or shape, or contains a number that is not finite.
    pub(super) fn read<T>(&mut self, name: &str, shape: &[Option<usize>]) -> anyhow::Result<(Vec<usize>, Vec<T>)>
    where
        T: Deserialize + Copy + Into<f64>,
    {
        let at = format!("`{name}` in {}", self.path.display());
        let mut bytes = Vec::new();
        match self.archive.zip_archive().by_name(&format!("{name}.npy")) {
            // Read to the end, where the checksum is compared.
            Ok(mut file) => {
                file.read_to_end(&mut bytes).with_context(|| format!("{at} is damaged; make the file again"))?
            }
            Err(error) => bail!("{at} cannot be read ({error}); make the file again"),
        };
        let array = NpyFile::new(&bytes[..]).with_context(|| format!("{at} is not an array; make the file again"))?;
        let found: Vec<usize> = array.shape().iter().map(|n| *n as usize).collect();
        let fits = found.len() == shape.len() && found.iter().zip(shape).all(|(n, s)| s.is_none_or(|s| s == *n));
        let shown =
            || shape.iter().map(|n| n.map_or("any".to_owned(), |n| n.to_string())).collect::<Vec<_>>().join(", ");
        ensure!(fits, "{at} has shape {found:?} where ({}) is needed", shown());
        ensure!(array.order() == Order::C || found.len() < 2, "{at} is in Fortran order; save it with `order=\"C\"`");
        ensure!(array.len() <= bytes.len() as u64, "{at} has less data than its shape says; make the file again");
        let kind = array.dtype().descr();
        let values: Vec<T> = array.into_vec().with_context(|| {
            format!("{at} has elements {kind} where {} bytes of a float are needed, or too few", size_of::<T>())
        })?;
        let odd = values.iter().position(|x| !(*x).into().is_finite());
        ensure!(odd.is_none(), "{at} contains a number that is not finite, at element {}", odd.unwrap_or_default());
        Ok((found, values))
    }
}

/// An archive in memory, the same bytes for the same arrays.
pub(super) struct Draft(NpzWriter<Cursor<Vec<u8>>>);

impl Draft {
    /// Without arrays.
    pub(super) fn new() -> Self {
        Self(NpzWriter::new(Cursor::new(Vec::new())))
    }

    /// The clock of the archive format would make equal arrays differ.
    fn options() -> FileOptions {
        FileOptions::default().compression_method(CompressionMethod::Stored).last_modified_time(DateTime::default())
    }

    /// Adds an array.
    pub(super) fn add<T: AutoSerialize>(&mut self, name: &str, shape: &[usize], values: Vec<T>) -> anyhow::Result<()> {
        let shape: Vec<u64> = shape.iter().map(|n| *n as u64).collect();
        let mut array = self.0.array(name, Self::options())?.default_dtype().shape(&shape).begin_nd()?;
        array.extend(values)?;
        Ok(array.finish()?)
    }

    /// Adds the bytes of a `.npy` file.
    pub(super) fn add_bytes(&mut self, name: &str, bytes: &[u8]) -> anyhow::Result<()> {
        let zip = self.0.zip_writer();
        zip.start_file(format!("{name}.npy"), Self::options())?;
        Ok(zip.write_all(bytes)?)
    }

    /// The archive's bytes.
    pub(super) fn bytes(mut self) -> anyhow::Result<Vec<u8>> {
        Ok(self.0.zip_writer().finish()?.into_inner())
    }
}

//! Points from NumPy's `.npy` and `.npz` files.
use anyhow::{Context, bail, ensure};
use glam::DVec3;
use npyz::{NpyFile, Order};
use std::io::{Cursor, Read};

/// Bytes of one array in an archive beyond which it is no point cloud.
const LARGEST: u64 = 1 << 30;

pub(super) fn points(bytes: &[u8]) -> anyhow::Result<Vec<DVec3>> {
    check_header(bytes)?;
    let file = NpyFile::new(bytes).context("its NumPy header is damaged")?;
    let (shape, order) = (file.shape().to_vec(), file.order());
    let &[count, 3] = &shape[..] else { bail!("its array has shape {shape:?}, but points need (N, 3)") };
    let numbers: Vec<f64> = match file.try_data::<f64>() {
        Ok(data) => data.collect::<Result<_, _>>().context("it is truncated")?,
        Err(file) => {
            let kind = file.dtype().descr();
            let Ok(data) = file.try_data::<f32>() else {
                bail!("its array holds {kind}, but points need f4 or f8; convert it with astype")
            };
            data.map(|x| x.map(f64::from)).collect::<Result<_, _>>().context("it is truncated")?
        }
    };
    let count = count as usize;
    let at = |row: usize, axis: usize| match order {
        Order::C => numbers[3 * row + axis],
        Order::Fortran => numbers[count * axis + row],
    };
    Ok((0..count).map(|i| DVec3::new(at(i, 0), at(i, 1), at(i, 2))).collect())
}

pub(super) fn archived_points(bytes: &[u8]) -> anyhow::Result<Vec<DVec3>> {
    let mut archive = npyz::npz::NpzArchive::new(Cursor::new(bytes)).context("it is no complete .npz archive")?;
    let names: Vec<String> = archive.array_names().map(str::to_owned).collect();
    let name = match &names[..] {
        [only] => only,
        _ => names
            .iter()
            .find(|n| *n == "positions")
            .with_context(|| format!("it holds the arrays {names:?}; name the one with the points \"positions\""))?,
    };
    let file = archive.zip_archive().by_name(&npyz::npz::file_name_from_array_name(name));
    let mut entry = file.with_context(|| format!("its array {name:?} is damaged"))?;
    let mut array = Vec::new();
    // Grows with what is really there, whatever size the archive claims.
    let length = entry.by_ref().take(LARGEST + 1).read_to_end(&mut array);
    let length = length.with_context(|| format!("its array {name:?} is truncated or damaged"))?;
    ensure!(length as u64 <= LARGEST, "its array {name:?} is larger than {LARGEST} bytes");
    points(&array).with_context(|| format!("its array {name:?} cannot be used"))
}

/// Refuses what would make the reader of the header allocate, recurse or overflow without bound.
fn check_header(bytes: &[u8]) -> anyhow::Result<()> {
    let damaged = "it is no NumPy array, or its header is truncated";
    let start = bytes.get(..12).filter(|b| b.starts_with(b"\x93NUMPY")).context(damaged)?;
    let (length, begin): (usize, usize) = match start[6] {
        1 => (usize::from(u16::from_le_bytes([start[8], start[9]])), 10),
        _ => (u32::from_le_bytes([start[8], start[9], start[10], start[11]]) as usize, 12),
    };
    let header = bytes.get(begin..begin.saturating_add(length)).context(damaged)?;
    let brackets = header.iter().filter(|b| b"([{".contains(b)).count();
    ensure!(brackets <= 16, "its NumPy header is nested too deeply for points");
    // Lengths of the axes and the size of an item: their product is the size of the data.
    let digits = header.split(|b| !b.is_ascii_digit()).filter(|d| d.iter().any(|&b| b != b'0'));
    let number = |d: &[u8]| d.iter().fold(0u128, |n, b| n.saturating_mul(10).saturating_add(u128::from(b - b'0')));
    let claimed = digits.map(number).fold(1u128, u128::saturating_mul);
    let there = (bytes.len() - begin - length) as u128;
    // The loader multiplies also when an axis has length zero, so that those are bounded too.
    let bound = there.max(1 << 16);
    ensure!(
        claimed <= bound,
        "its header claims {claimed} bytes of data but {there} follow; it is truncated or damaged"
    );
    Ok(())
}

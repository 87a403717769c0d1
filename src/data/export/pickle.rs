//! A NumPy object array of two arrays, which only a pickle can hold.
use super::Trajectory;
use anyhow::Context;

/// Opcodes of Python's pickle protocol 3 (`pickletools` explains them).
mod op {
    pub(super) const PROTO: u8 = 0x80;
    pub(super) const GLOBAL: u8 = b'c';
    pub(super) const MARK: u8 = b'(';
    pub(super) const STOP: u8 = b'.';
    pub(super) const REDUCE: u8 = b'R';
    pub(super) const BUILD: u8 = b'b';
    pub(super) const TUPLE: u8 = b't';
    pub(super) const APPENDS: u8 = b'e';
    pub(super) const EMPTY_LIST: u8 = b']';
    pub(super) const NONE: u8 = b'N';
    pub(super) const TRUE: u8 = 0x88;
    pub(super) const FALSE: u8 = 0x89;
    pub(super) const INT: u8 = b'J';
    pub(super) const TEXT: u8 = b'X';
    pub(super) const BYTES: u8 = b'B';
}

/// The bytes of a `.npy` file: an object array of shape (2) with the positions, float32 (frames, particles, 3), and the types,
/// int64 (particles).
///
/// # Errors
/// When an array has 4 GiB or more.
pub(super) fn object_array(trajectory: &Trajectory) -> anyhow::Result<Vec<u8>> {
    let Trajectory { positions, frames, types } = trajectory;
    let position_bytes: Vec<u8> = positions.iter().flat_map(|x| x.to_le_bytes()).collect();
    let type_bytes: Vec<u8> = types.iter().flat_map(|x| x.to_le_bytes()).collect();

    // An array is an empty one, rebuilt with (version, shape, dtype, Fortran order, data); that of objects has a list for data.
    let mut pickle = Pickle(vec![op::PROTO, 3]);
    pickle.empty_array();
    pickle.0.push(op::MARK);
    pickle.state(&[2], "O8", '|')?;
    pickle.0.extend([op::EMPTY_LIST, op::MARK]);
    pickle.array(&[*frames, types.len(), 3], "f4", &position_bytes)?;
    pickle.array(&[types.len()], "i8", &type_bytes)?;
    pickle.0.extend([op::APPENDS, op::TUPLE, op::BUILD, op::STOP]);

    // Magic, version 1.0, the length of the header, and the header padded so that the data begins at a multiple of 64.
    let mut header = "{'descr': '|O', 'fortran_order': False, 'shape': (2,), }".to_owned();
    while !(10 + header.len() + 1).is_multiple_of(64) {
        header.push(' ');
    }
    header.push('\n');
    let length = u16::try_from(header.len())?.to_le_bytes();
    Ok([b"\x93NUMPY\x01\x00", &length[..], header.as_bytes(), &pickle.0].concat())
}

struct Pickle(Vec<u8>);

impl Pickle {
    fn global(&mut self, module: &str, name: &str) {
        self.0.push(op::GLOBAL);
        self.0.extend(format!("{module}\n{name}\n").bytes());
    }

    fn int(&mut self, value: usize) -> anyhow::Result<()> {
        self.0.push(op::INT);
        self.0.extend(i32::try_from(value).context("an array axis is too long")?.to_le_bytes());
        Ok(())
    }

    fn text(&mut self, text: &str) {
        self.0.push(op::TEXT);
        self.0.extend((text.len() as u32).to_le_bytes());
        self.0.extend(text.bytes());
    }

    fn data(&mut self, bytes: &[u8]) -> anyhow::Result<()> {
        let length = u32::try_from(bytes.len()).context("a trajectory has 4 GiB or more")?;
        self.0.push(op::BYTES);
        self.0.extend(length.to_le_bytes());
        self.0.extend(bytes);
        Ok(())
    }

    /// `_reconstruct(ndarray, (0,), b'b')`; NumPy before 2 and since 2 both know it by this name.
    fn empty_array(&mut self) {
        self.global("numpy.core.multiarray", "_reconstruct");
        self.0.push(op::MARK);
        self.global("numpy", "ndarray");
        self.0.extend([op::MARK, op::INT, 0, 0, 0, 0, op::TUPLE]);
        self.0.extend([op::BYTES, 1, 0, 0, 0, b'b', op::TUPLE, op::REDUCE]);
    }

    /// The beginning of an array's state: version, shape, dtype, row-major order.
    fn state(&mut self, shape: &[usize], kind: &str, order: char) -> anyhow::Result<()> {
        self.int(1)?;
        self.0.push(op::MARK);
        shape.iter().try_for_each(|n| self.int(*n))?;
        self.0.push(op::TUPLE);
        self.dtype(kind, order)?;
        self.0.push(op::FALSE);
        Ok(())
    }

    /// `dtype(kind, False, True)` with the state (3, order, None, None, None, −1, −1, flags).
    fn dtype(&mut self, kind: &str, order: char) -> anyhow::Result<()> {
        self.global("numpy", "dtype");
        self.0.push(op::MARK);
        self.text(kind);
        self.0.extend([op::FALSE, op::TRUE, op::TUPLE, op::REDUCE, op::MARK]);
        self.int(3)?;
        self.text(&order.to_string());
        self.0.extend([op::NONE; 3]);
        for _ in 0..2 {
            self.0.push(op::INT);
            self.0.extend((-1i32).to_le_bytes());
        }
        // What NumPy's own pickles say: objects are counted references, numbers are not.
        self.int(if kind.starts_with('O') { 63 } else { 0 })?;
        self.0.extend([op::TUPLE, op::BUILD]);
        Ok(())
    }

    fn array(&mut self, shape: &[usize], kind: &str, bytes: &[u8]) -> anyhow::Result<()> {
        self.empty_array();
        self.0.push(op::MARK);
        self.state(shape, kind, '<')?;
        self.data(bytes)?;
        self.0.extend([op::TUPLE, op::BUILD]);
        Ok(())
    }
}

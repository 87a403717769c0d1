//! The instructions of straight-line programs, for one number and for blocks of them.
use super::expression::Function;

/// Numbers that one instruction handles in a row, so that its dispatch costs nothing beside them and all registers stay in the
/// first-level cache.
pub const BLOCK: usize = CHUNKS * LANES;
const CHUNKS: usize = 8;
/// Numbers that one vector register or two hold.
const LANES: usize = 8;

/// The values of one register over a block.
#[derive(Clone, Copy, Debug)]
#[repr(align(64))]
pub(super) struct Lane([[f64; LANES]; CHUNKS]);

impl Lane {
    pub(super) fn filled(value: f64) -> Self {
        Self([[value; LANES]; CHUNKS])
    }

    pub(super) fn values(&self) -> &[f64; BLOCK] {
        self.0.as_flattened().try_into().expect("a block has BLOCK numbers")
    }

    pub(super) fn values_mut(&mut self) -> &mut [f64; BLOCK] {
        self.0.as_flattened_mut().try_into().expect("a block has BLOCK numbers")
    }
}

/// What an instruction does with its operands; those of one operand ignore the second.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Operation {
    Add,
    Subtract,
    Multiply,
    Divide,
    Max,
    Min,
    Root,
    Power(f64),
    Apply(Function),
}

/// Calls `$run` with the closure of an operation, so that the loop inside is compiled once for each.
macro_rules! dispatch {
    ($operation:expr, $run:ident) => {
        match $operation {
            Operation::Add => $run!(|a: f64, b: f64| a + b),
            Operation::Subtract => $run!(|a: f64, b: f64| a - b),
            Operation::Multiply => $run!(|a: f64, b: f64| a * b),
            Operation::Divide => $run!(|a: f64, b: f64| a / b),
            // Written out, these are one instruction; `f64::max` is several.
            Operation::Max => $run!(|a: f64, b: f64| if a > b { a } else { b }),
            Operation::Min => $run!(|a: f64, b: f64| if a < b { a } else { b }),
            Operation::Root => $run!(|a: f64, _: f64| a.sqrt()),
            Operation::Power(p) => $run!(|a: f64, _: f64| a.powf(p)),
            Operation::Apply(Function::Exp) => $run!(|a: f64, _: f64| a.exp()),
            Operation::Apply(Function::Log) => $run!(|a: f64, _: f64| a.ln()),
            Operation::Apply(Function::Tanh) => $run!(|a: f64, _: f64| a.tanh()),
            Operation::Apply(Function::Abs) => $run!(|a: f64, _: f64| a.abs()),
            Operation::Apply(Function::Sign) => {
                $run!(|a: f64, _: f64| f64::from(u8::from(a > 0.0)) - f64::from(u8::from(a < 0.0)))
            }
            Operation::Apply(Function::Step) => $run!(|a: f64, _: f64| if a > 0.0 { 1.0 } else { 0.0 }),
        }
    };
}

impl Operation {
    /// Of one number or two.
    pub(super) fn of(self, a: f64, b: f64) -> f64 {
        macro_rules! once {
            ($f:expr) => {
                $f(a, b)
            };
        }
        dispatch!(self, once)
    }

    /// Of whole registers.
    #[inline]
    pub(super) fn run(self, registers: &mut [Lane], a: usize, b: usize, out: usize) {
        let count = registers.len();
        assert!(a < count && b < count && out < count, "a register out of range");
        macro_rules! whole {
            ($f:expr) => {
                for k in 0..CHUNKS {
                    // Read before it is written: the result may stand in an operand's place.
                    let (x, y) = (registers[a].0[k], registers[b].0[k]);
                    registers[out].0[k] = std::array::from_fn(|i| $f(x[i], y[i]));
                }
            };
        }
        dispatch!(self, whole);
    }
}

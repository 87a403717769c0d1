//! Straight-line programs over whole arrays, a block of numbers an instruction.
use super::expression::{Expressions, Id};
use super::interval::Interval;
use super::lower::{Value, lower};
use super::operation::{BLOCK, Lane, Operation};

/// Instructions on registers, several inputs and outputs.
#[derive(Clone, Debug)]
pub struct Program {
    inputs: usize,
    constants: Vec<(usize, f64)>,
    instructions: Vec<Step>,
    outputs: Vec<usize>,
    registers: usize,
}

#[derive(Clone, Copy, Debug)]
struct Step {
    operation: Operation,
    operands: [usize; 2],
    out: usize,
}

/// The registers of a running program.
pub struct Workspace(Vec<Lane>);

impl Workspace {
    /// The values of an input for the next block.
    pub fn input(&mut self, place: usize) -> &mut [f64; BLOCK] {
        self.0[place].values_mut()
    }
}

impl Program {
    /// Compiles `roots` as outputs, `inputs` (places among the names) as inputs; a name with a range of one value is a constant.
    ///
    /// # Panics
    /// When a name that varies is no input.
    pub fn new(expressions: &Expressions, roots: &[Id], inputs: &[u32], ranges: &[Interval]) -> Self {
        let lowered = lower(expressions, roots, ranges);
        let mut last = vec![0; lowered.instructions.len()];
        for (at, instruction) in lowered.instructions.iter().enumerate() {
            for operand in instruction.operands {
                if let Value::Result(made) = operand {
                    last[made as usize] = at;
                }
            }
        }
        for output in &lowered.outputs {
            if let Value::Result(made) = output {
                last[*made as usize] = usize::MAX;
            }
        }
        let mut program = Self {
            inputs: inputs.len(),
            constants: Vec::new(),
            instructions: Vec::new(),
            outputs: Vec::new(),
            registers: inputs.len(),
        };
        let values = lowered.instructions.iter().flat_map(|i| i.operands).chain(lowered.outputs.iter().copied());
        for value in values {
            if let Value::Constant(constant) = value {
                program.constant(constant);
            }
        }
        let (mut places, mut free) = (vec![0; last.len()], Vec::new());
        for (at, instruction) in lowered.instructions.iter().enumerate() {
            let operands = instruction.operands.map(|value| program.place(value, inputs, &places));
            // An operand's register is free for the result when this is its last use.
            for (value, place) in instruction.operands.iter().zip(operands) {
                if let Value::Result(made) = value
                    && last[*made as usize] == at
                    && !free.contains(&place)
                {
                    free.push(place);
                }
            }
            let out = free.pop().unwrap_or_else(|| {
                program.registers += 1;
                program.registers - 1
            });
            places[at] = out;
            program.instructions.push(Step { operation: instruction.operation, operands, out });
        }
        program.outputs = lowered.outputs.iter().map(|value| program.place(*value, inputs, &places)).collect();
        program
    }

    fn constant(&mut self, value: f64) -> usize {
        let known = self.constants.iter().find(|(_, c)| c.to_bits() == value.to_bits());
        known.map(|(place, _)| *place).unwrap_or_else(|| {
            self.constants.push((self.registers, value));
            self.registers += 1;
            self.registers - 1
        })
    }

    fn place(&mut self, value: Value, inputs: &[u32], places: &[usize]) -> usize {
        match value {
            Value::Name(name) => inputs.iter().position(|i| *i == name).expect("every name that varies is an input"),
            Value::Constant(constant) => self.constant(constant),
            Value::Result(made) => places[made as usize],
        }
    }

    /// Operations for every element of an array.
    pub fn operations(&self) -> usize {
        self.instructions.len()
    }

    /// Registers with every constant in its place.
    pub fn workspace(&self) -> Workspace {
        let mut registers = vec![Lane::filled(0.0); self.registers];
        self.constants.iter().for_each(|(place, value)| registers[*place] = Lane::filled(*value));
        Workspace(registers)
    }

    /// Computes one block from the inputs in `workspace`.
    pub fn run(&self, workspace: &mut Workspace) {
        for Step { operation, operands: [a, b], out } in &self.instructions {
            operation.run(&mut workspace.0, *a, *b, *out);
        }
    }

    /// An output after [`Program::run`].
    pub fn output<'a>(&self, workspace: &'a Workspace, place: usize) -> &'a [f64; BLOCK] {
        workspace.0[self.outputs[place]].values()
    }

    /// Every output at `count` points, from an array of each input.
    pub fn evaluate(&self, count: usize, inputs: &[&[f64]]) -> Vec<Vec<f64>> {
        assert_eq!(inputs.len(), self.inputs, "an array for every input");
        let mut workspace = self.workspace();
        let mut outputs = vec![Vec::with_capacity(count); self.outputs.len()];
        for start in (0..count).step_by(BLOCK) {
            let size = BLOCK.min(count - start);
            for (place, array) in inputs.iter().enumerate() {
                workspace.input(place)[..size].copy_from_slice(&array[start..start + size]);
            }
            self.run(&mut workspace);
            for (place, out) in outputs.iter_mut().enumerate() {
                out.extend_from_slice(&self.output(&workspace, place)[..size]);
            }
        }
        outputs
    }
}

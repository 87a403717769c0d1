//! No tool: what the scene does by itself.
use super::{Motion, Tool, Workpiece};
use crate::state::{ActionSpace, Control, ToolShape};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// Empty hands; θ has no numbers.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct WaitSpec {}

/// See [`WaitSpec`].
#[derive(Clone, Debug)]
pub struct Wait(Arc<ToolShape>);

impl WaitSpec {
    /// Empty hands.
    ///
    /// # Errors
    /// None.
    pub fn build(self) -> anyhow::Result<Wait> {
        Ok(Wait(Arc::new(ToolShape::from(Vec::new()))))
    }
}

impl Tool for Wait {
    fn shape(&self) -> &Arc<ToolShape> {
        &self.0
    }

    fn space(&self, _: &Workpiece) -> ActionSpace {
        ActionSpace { names: Vec::new(), low: Vec::new(), high: Vec::new() }
    }

    fn motion(&self, _: &[f64], _: &Workpiece, steps: usize) -> Motion {
        Motion { start: Vec::new(), controls: vec![Control::default(); steps] }
    }
}

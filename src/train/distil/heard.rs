//! The messages of a model in recorded scenes.
use super::Distiller;
use super::samples::{Samples, Variable};
use crate::data::Episode;
use crate::model::WorldModel;
use crate::model::formula::Interval;
use crate::model::law::Message;
use crate::model::law::formula::Between;
use crate::train::split::{Split, Tools, set_aside};
use crate::train::spread::spread;
use crate::train::windows::Windows;
use anyhow::ensure;
use rayon::prelude::*;

/// Messages in the scenes of a dataset.
#[derive(Clone, Debug, Default)]
pub struct Heard {
    /// That formulas are fitted to.
    pub fit: Vec<Message>,
    /// That they are chosen by.
    pub validation: Vec<Message>,
    /// That neither has seen.
    pub held_out: Vec<Message>,
}

/// Who meets whom, and the lengths and speeds that count as one.
#[derive(Clone, Debug, PartialEq)]
pub struct Encounter {
    /// Name of the edges.
    pub edge: String,
    /// Their place in [`crate::graph::EDGE_KINDS`].
    pub kind: usize,
    /// What a formula law calls it.
    pub between: Between,
    /// Distance beyond which there are no messages \[m\].
    pub reach: f64,
    /// Speed that counts as one \[m/s\].
    pub speed: f64,
}

/// A component of a message.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Component {
    /// N.
    Normal,
    /// T.
    Tangential,
}

impl Component {
    /// Of a message \[m/s²\].
    pub fn of(self, message: &Message) -> f64 {
        match self {
            Self::Normal => message.normal,
            Self::Tangential => message.tangential,
        }
    }

    /// The key of a law's config that holds its formula.
    pub fn key(self) -> &'static str {
        match self {
            Self::Normal => "normal_force",
            Self::Tangential => "tangential_force",
        }
    }
}

impl Distiller {
    /// What `model` says at the start of control steps of `data`.
    ///
    /// # Errors
    /// As [`Windows::new`]; when the model does not accept a scene, or says what is not finite.
    pub fn listen(&self, model: &dyn WorldModel, data: &Split) -> anyhow::Result<Heard> {
        let (fit, aside) = set_aside(&data.train, self.spec.validation);
        Ok(Heard {
            fit: self.messages(model, &fit, &data.tools)?,
            validation: self.messages(model, &aside, &data.tools)?,
            held_out: self.messages(model, &data.held_out.iter().collect::<Vec<_>>(), &data.tools)?,
        })
    }

    fn messages(&self, model: &dyn WorldModel, of: &[&Episode], tools: &Tools) -> anyhow::Result<Vec<Message>> {
        let windows = Windows::new(of.iter().copied(), tools, 1, 0.0)?.spread(self.spec.windows);
        windows.iter().try_for_each(|w| model.accepts(&w.scene))?;
        let said: Vec<Vec<Message>> = windows.par_iter().map(|w| model.messages(&w.scene, &w.controls[0])).collect();
        let said = said.concat();
        let finite = |m: &Message| {
            [m.distance, m.separating, m.sliding, m.normal, m.tangential].iter().all(|number| number.is_finite())
        };
        let flaw = said.iter().position(|m| !finite(m));
        ensure!(flaw.is_none(), "a message of the model is not finite: {:?}", said[flaw.unwrap_or(0)]);
        Ok(said)
    }
}

impl Encounter {
    /// At most `count` of its messages, at even distances.
    pub(super) fn some(&self, all: &[Message], count: usize) -> Vec<Message> {
        let own: Vec<Message> = all.iter().filter(|m| m.kind == self.kind).copied().collect();
        spread(count, own.len()).map(|i| own[i]).collect()
    }

    /// A component of messages, in units of `force` \[m/s²\], over r and overlap in units of the reach, v_n and v_t in units of the
    /// speed and, for the tangential component, N.
    pub(super) fn samples(&self, messages: &[Message], component: Component, force: f64) -> Samples {
        let (distance, overlap) = match self.between {
            Between::Particles => (Interval::open(0.0, 1.0), Interval::open(0.0, 1.0)),
            _ => (Interval::open(f64::NEG_INFINITY, 1.0), Interval::open(0.0, f64::INFINITY)),
        };
        let column = |name, range, of: &dyn Fn(&Message) -> f64| Variable {
            name,
            range,
            values: messages.iter().map(of).collect(),
        };
        let mut variables = vec![
            column("r", distance, &|m| m.distance / self.reach),
            column("overlap", overlap, &|m| 1.0 - m.distance / self.reach),
            column("vn", Interval::ALL, &|m| m.separating / self.speed),
            column("vt", Interval::open(0.0, f64::INFINITY), &|m| m.sliding / self.speed),
        ];
        if component == Component::Tangential {
            variables.push(column("normal", Interval::ALL, &|m| m.normal / force));
        }
        Samples { variables, target: messages.iter().map(|m| component.of(m) / force).collect() }
    }
}

//! Laws as formulas: text is parsed, differentiated, simplified by equality saturation and compiled to a program over arrays.
//!
//! ```text
//! energy = "k/2.5 * max(0, d - r)^2.5"
//! ```
//!
//! Numbers are exact until a program is compiled. Differentiation comes first, rule by rule; simplification then uses only
//! rewrites that hold where the variables lie in their stated ranges, and is believed only if the program agrees with the plain
//! formula at a thousand points.
mod chain;
mod check;
mod compile;
mod count;
mod derivative;
mod error;
mod evaluate;
mod explain;
mod expression;
mod extract;
mod facts;
mod form;
mod interval;
mod lower;
mod operation;
mod parse;
mod print;
mod program;
mod range;
mod rational;
mod rules;
mod simplify;
mod term;
mod token;

pub use check::{POINTS, Verdict};
pub use compile::{Compiled, Operations, compile};
pub use derivative::Direction;
pub use error::FormulaError;
pub use explain::explain;
pub use expression::{Expressions, FUNCTIONS, Function, Id, Node};
pub use form::{Form, Forms};
pub use interval::Interval;
pub use operation::BLOCK;
pub use parse::Names;
pub use program::{Program, Workspace};
pub use range::Range;
pub use rational::Rational;
pub use simplify::simplify;

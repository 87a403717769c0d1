//! Formulas without units, written as a law's config has them.
use super::fitted::Fitted;
use super::heard::{Component, Encounter};
use crate::model::formula::{Form, Forms, Interval};
use indexmap::IndexMap;

/// A formula in SI units, and its constants.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Written {
    pub(super) text: String,
    pub(super) constants: IndexMap<String, f64>,
}

impl Encounter {
    /// `force · f` in metres and seconds, r and overlap still over the reach; constants are positive, named by the component.
    pub(super) fn written(&self, found: &Fitted, component: Component, force: f64) -> Written {
        let (mut e, mut root) = (found.form.expressions.clone(), found.form.root);
        let mut known: IndexMap<String, f64> =
            found.constants.iter().enumerate().map(|(k, c)| (Form::constant(k), *c)).collect();
        // What a unit is joins the constants, and mostly disappears in one of them.
        for (name, unit) in [("vn", self.speed), ("vt", self.speed), ("normal", force)] {
            let (variable, share) = (e.name(name), format!("per_{name}"));
            let scaled = e.name(&share);
            let scaled = e.product(scaled, variable);
            root = e.substituted(root, name, scaled);
            known.insert(share, unit.recip());
        }
        let scale = e.name("force");
        root = e.product(scale, root);
        known.insert("force".to_owned(), force);
        let range = |name: &String| match known.get(name) {
            Some(value) => Interval::closed(*value, *value),
            None if ["vn", "normal"].contains(&name.as_str()) => Interval::ALL,
            None => Interval::open(0.0, f64::INFINITY),
        };
        let ranges: Vec<Interval> = e.names().iter().map(range).collect();
        let form = Forms::default().of(&e, root, &ranges).expect("a formula of finite constants");

        let prefix = if component == Component::Normal { "c" } else { "t" };
        let (mut e, mut root, mut constants) = (form.expressions, form.root, IndexMap::new());
        // Names that are no form's, so that none is taken for another.
        for (k, value) in form.constants.iter().enumerate() {
            let own = e.name(&format!("own{k}"));
            let signed = if *value < 0.0 { e.negative(own) } else { own };
            root = e.substituted(root, &Form::constant(k), signed);
            constants.insert(format!("{prefix}{k}"), value.abs());
        }
        for (k, name) in constants.keys().enumerate() {
            let named = e.name(name);
            root = e.substituted(root, &format!("own{k}"), named);
        }
        for name in ["r", "overlap"] {
            let (length, reach) = (e.name(name), e.name("reach"));
            let ratio = e.quotient(length, reach);
            root = e.substituted(root, name, ratio);
        }
        Written { text: e.print(root), constants }
    }
}

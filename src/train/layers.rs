//! Which of a model's weights go on learning, by the names of its layers.
use std::ops::Range;

/// Whether `name` is `layer`, or a part of it.
fn belongs(name: &str, layer: &str) -> bool {
    name.strip_prefix(layer).is_some_and(|rest| rest.is_empty() || rest.starts_with('.'))
}

/// Places in the flat list of the weights that no one of `layers` holds; none where no layer is named, for then all learn.
///
/// # Errors
/// A sentence that lists the model's layers, when one that is named is none of them.
pub(super) fn frozen(matrices: &[(String, usize)], layers: &[String]) -> anyhow::Result<Vec<Range<usize>>> {
    if let Some(strange) = layers.iter().find(|layer| !matrices.iter().any(|(name, _)| belongs(name, layer))) {
        let layer =
            |(name, _): &(String, usize)| name.rsplit_once('.').map_or(&name[..], |(layer, _)| layer).to_owned();
        let mut known: Vec<String> = matrices.iter().map(layer).collect();
        known.dedup();
        anyhow::ensure!(
            !known.is_empty(),
            "`layers` of the training config names `{strange}`, but the model's weights have no names; leave `layers` out"
        );
        anyhow::bail!(
            "`layers` of the training config names `{strange}`, which is no layer of the model, nor what names of layers begin with up \
             to a dot; they are {}",
            known.join(", ")
        );
    }
    let mut end = 0;
    let places = matrices.iter().map(|(name, count)| {
        end += count;
        (name, end - count..end)
    });
    let still = |name: &str| !layers.is_empty() && !layers.iter().any(|layer| belongs(name, layer));
    Ok(places.filter(|(name, _)| still(name)).map(|(_, place)| place).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(layers: &[&str]) -> anyhow::Result<Vec<Range<usize>>> {
        let matrices = [("node.weight", 6), ("node.bias", 3), ("nodes.weight", 2), ("round.1.update.weight", 4)];
        let matrices = matrices.map(|(name, count)| (name.to_owned(), count));
        frozen(&matrices, &layers.iter().map(|layer| (*layer).to_owned()).collect::<Vec<_>>())
    }

    #[test]
    fn a_layer_is_meant_by_its_name_or_by_the_beginning_of_it_up_to_a_dot() {
        assert_eq!(of(&[]).unwrap(), [], "all learn");
        assert_eq!(of(&["node"]).unwrap(), [9..11, 11..15]);
        assert_eq!(of(&["round.1", "node.bias"]).unwrap(), [0..6, 9..11]);
    }

    #[test]
    fn a_layer_that_is_none_is_a_sentence_with_those_that_are() {
        let refused = of(&["node", "round.1.up"]).unwrap_err().to_string();
        assert!(refused.contains("`round.1.up`") && refused.ends_with("node, nodes, round.1.update"), "{refused}");
        let refused = frozen(&[], &["node".to_owned()]).unwrap_err().to_string();
        assert!(refused.contains("have no names"), "{refused}");
    }
}

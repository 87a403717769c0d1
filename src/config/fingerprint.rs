//! A short name for everything a result depends on.
use serde::Serialize;
use serde_json::Value as Json;
use sha2::{Digest, Sha256};
use std::fmt;

/// The first 48 bits of the SHA-256 of a value's canonical JSON (keys sorted), shown as 12 hexadecimal digits.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Fingerprint([u8; 6]);

/// The fingerprint of a value: equal for equal values, whatever the order of their keys.
pub fn fingerprint(spec: &impl Serialize) -> Fingerprint {
    let json = serde_json::to_value(spec).expect("specs have string keys and derived serialisation");
    let digest = Sha256::digest(sorted(json).to_string());
    let mut short = [0; 6];
    short.copy_from_slice(&digest[..6]);
    Fingerprint(short)
}

fn sorted(json: Json) -> Json {
    match json {
        Json::Array(items) => items.into_iter().map(sorted).collect(),
        Json::Object(members) => {
            let mut members: Vec<(String, Json)> = members.into_iter().collect();
            members.sort_by(|a, b| a.0.cmp(&b.0));
            members.into_iter().map(|(key, value)| (key, sorted(value))).collect()
        }
        leaf => leaf,
    }
}

impl fmt::Display for Fingerprint {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.iter().try_for_each(|byte| write!(f, "{byte:02x}"))
    }
}

impl Serialize for Fingerprint {
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(self)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn the_order_of_keys_does_not_matter_and_every_value_does() {
        let one = fingerprint(&json!({ "a": 1, "b": { "c": [1, 2], "d": 0.5 } }));
        assert_eq!(one, fingerprint(&json!({ "b": { "d": 0.5, "c": [1, 2] }, "a": 1 })));
        assert_ne!(one, fingerprint(&json!({ "a": 1, "b": { "c": [2, 1], "d": 0.5 } })));
        assert_ne!(one, fingerprint(&json!({ "a": 1, "b": { "c": [1, 2], "d": 0.25 } })));
    }

    #[test]
    fn it_is_the_sha_256_of_canonical_json() {
        // sha256sum of the four bytes `{"a":1}`, taken with coreutils
        assert_eq!(fingerprint(&json!({ "a": 1 })).to_string(), "015abd7f5cc5");
    }
}

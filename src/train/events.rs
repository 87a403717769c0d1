//! TensorBoard's event file: the numbers of `metrics.jsonl` as the curves that `tensorboard --logdir` draws.
//!
//! A record is `length u64 | crc of it u32 | data | crc of it u32`, little-endian, the sums being CRC-32C (RFC 3720, B.4) turned and
//! shifted (TensorFlow's TFRecord format); the data is an `Event` in Protocol Buffers' encoding.
use serde_json::Value;

/// What every file begins with.
const VERSION: &str = "brain.Event:2";

/// The first record of a file.
pub(super) fn head() -> Vec<u8> {
    record(&event(0.0, 0, &text(3, VERSION.as_bytes())))
}

/// The numbers of one line of the journal: its `step`, and a curve each of the others, a table's called `table/key`; the wall time is
/// `seconds` since the run began.
pub(super) fn line(line: &Value) -> Vec<u8> {
    let number = |key: &str| line[key].as_f64().unwrap_or(0.0);
    let members = line.as_object().into_iter().flatten().filter(|(key, _)| key.as_str() != "step");
    let summary: Vec<u8> = members.flat_map(|(key, value)| curves(key, value)).collect();
    record(&event(number("seconds"), number("step") as u64, &text(5, &summary)))
}

/// What is no number, as an infinite error in JSON, is left out: the curve has a gap there.
fn curves(tag: &str, value: &Value) -> Vec<u8> {
    match value {
        Value::Object(table) => table.iter().flat_map(|(key, value)| curves(&format!("{tag}/{key}"), value)).collect(),
        value => value.as_f64().map_or_else(Vec::new, |value| text(1, &curve(tag, value as f32))),
    }
}

/// `Summary.Value { tag = 1, simple_value = 2 }`.
fn curve(tag: &str, value: f32) -> Vec<u8> {
    [text(1, tag.as_bytes()), vec![2 << 3 | 5], value.to_le_bytes().to_vec()].concat()
}

/// `Event { wall_time = 1, step = 2, what }`.
fn event(wall_time: f64, step: u64, what: &[u8]) -> Vec<u8> {
    [&[1 << 3 | 1][..], &wall_time.to_le_bytes(), &[2 << 3], &varint(step), what].concat()
}

/// A field of bytes.
fn text(field: u8, bytes: &[u8]) -> Vec<u8> {
    [&[field << 3 | 2][..], &varint(bytes.len() as u64), bytes].concat()
}

/// Seven bits a byte, the lowest first, the eighth set in all but the last.
fn varint(mut value: u64) -> Vec<u8> {
    let mut bytes = Vec::new();
    while value >= 0x80 {
        bytes.push(value as u8 | 0x80);
        value >>= 7;
    }
    bytes.push(value as u8);
    bytes
}

fn record(data: &[u8]) -> Vec<u8> {
    let length = (data.len() as u64).to_le_bytes();
    [&length[..], &masked(&length), data, &masked(data)].concat()
}

fn masked(bytes: &[u8]) -> [u8; 4] {
    crc32c(bytes).rotate_right(15).wrapping_add(0xa282_ead8).to_le_bytes()
}

/// Castagnoli's polynomial, bits reflected; a line is some hundred bytes, so that a table would not pay.
fn crc32c(bytes: &[u8]) -> u32 {
    let bit = |crc: u32, _| if crc & 1 == 1 { crc >> 1 ^ 0x82f6_3b78 } else { crc >> 1 };
    !bytes.iter().fold(u32::MAX, |crc, byte| (0..8).fold(crc ^ u32::from(*byte), bit))
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn the_sum_is_that_of_the_standard() {
        // RFC 3720, B.4, and the check value of every catalogue of sums.
        assert_eq!(crc32c(&[0; 32]), 0x8a91_36aa);
        assert_eq!(crc32c(&[0xff; 32]), 0x62a8_ab43);
        assert_eq!(crc32c(b"123456789"), 0xe306_9283);
    }

    #[test]
    fn numbers_of_more_than_seven_bits_spread_over_bytes() {
        // Protocol Buffers, Encoding, "Base 128 Varints": 150 is 9601.
        assert_eq!((varint(150), varint(1), varint(0)), (vec![0x96, 0x01], vec![1], vec![0]));
    }

    #[test]
    fn a_line_becomes_its_step_its_time_and_a_curve_each() {
        let bytes = line(&json!({ "step": 300, "loss": 0.5, "seconds": 2.0, "rollout": null, "k": { "a": 1 } }));
        let length = u64::from_le_bytes(bytes[..8].try_into().unwrap()) as usize;
        assert_eq!(bytes.len(), length + 16);
        let data = &bytes[12..12 + length];
        let expected = [
            &[0x09][..],
            &2.0f64.to_le_bytes(),
            &[0x10, 0xac, 0x02, 0x2a, 13 + 16 + 12],
            &[0x0a, 11, 0x0a, 4],
            b"loss",
            &[0x15],
            &0.5f32.to_le_bytes(),
            &[0x0a, 14, 0x0a, 7],
            b"seconds",
            &[0x15],
            &2.0f32.to_le_bytes(),
            &[0x0a, 10, 0x0a, 3],
            b"k/a",
            &[0x15],
            &1.0f32.to_le_bytes(),
        ];
        assert_eq!(data, expected.concat());
    }
}

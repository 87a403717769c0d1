//! What somebody probably meant.

/// The candidate most like `word`, when one is alike at all.
pub(crate) fn nearest<'a>(word: &str, candidates: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    let word = word.to_lowercase();
    let alike = |candidate: &str| {
        let candidate = candidate.to_lowercase();
        let edits = strsim::normalized_damerau_levenshtein(&word, &candidate);
        let part = word.len() >= 3 && candidate.len() >= 3 && (candidate.contains(&word) || word.contains(&candidate));
        if part { edits.max(0.6) } else { edits }
    };
    let scored = candidates.into_iter().map(|candidate| (alike(candidate), candidate));
    scored.filter(|(score, _)| *score >= 0.5).max_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, candidate)| candidate)
}

/// Words as "`a`, `b` and `c`".
pub(super) fn enumerate<'a>(words: impl IntoIterator<Item = &'a str>) -> String {
    let quoted: Vec<String> = words.into_iter().map(|word| format!("`{word}`")).collect();
    match quoted.split_last() {
        None => "nothing".to_owned(),
        Some((last, [])) => last.clone(),
        Some((last, rest)) => format!("{} and {last}", rest.join(", ")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_slip_of_the_keys_is_understood_and_nonsense_is_not() {
        let keys = ["samples", "elites", "rounds"];
        assert_eq!(nearest("sampels", keys), Some("samples"));
        assert_eq!(nearest("Elite", keys), Some("elites"));
        assert_eq!(nearest("sample", keys), Some("samples"));
        assert_eq!(nearest("quux", keys), None);
        assert_eq!(nearest("x", []), None);
    }

    #[test]
    fn words_are_listed_as_a_sentence_lists_them() {
        assert_eq!(enumerate(["a", "b", "c"]), "`a`, `b` and `c`");
        assert_eq!(enumerate(["a"]), "`a`");
        assert_eq!(enumerate([]), "nothing");
    }
}

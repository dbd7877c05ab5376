//! The corpora of the fuzz targets, as they are and a little changed: everything that reads comes back from everything.
#![expect(clippy::expect_used, reason = "a test that cannot go on has failed")]

#[path = "../fuzz/mutate.rs"]
mod mutate;
#[path = "../fuzz/targets.rs"]
mod targets;

use mutate::Corpus;
use targets::TARGETS;

/// Changed inputs of each target, of a thousand times its share of them.
const CHANGED: u64 = 4000;

#[test]
fn everything_that_reads_comes_back_from_the_corpora_and_from_what_is_made_of_them() {
    for target in &TARGETS {
        let corpus = Corpus::read(target.name).unwrap();
        assert!(!corpus.inputs().is_empty(), "{} has no corpus", target.name);
        corpus.inputs().iter().for_each(|input| (target.run)(input));
        (0..CHANGED * target.share / 1000).for_each(|number| (target.run)(&corpus.changed(7, number)));
    }
}

#[test]
fn an_input_is_the_same_for_the_same_seed_and_number() {
    let corpus = Corpus::read("config").unwrap();
    assert_eq!(corpus.changed(3, 17), corpus.changed(3, 17));
    assert!((0..50).any(|number| corpus.changed(3, number) != corpus.changed(4, number)));
}

#[test]
fn every_log_of_the_corpus_is_a_recording_of_three_pictures() {
    for entry in std::fs::read_dir("fuzz/corpus/mcap").unwrap() {
        let file = entry.unwrap().path();
        let mut source = seamtrack::source::open(&file, seamtrack::source::Period::OwnOr(0.2)).unwrap();
        let pictures = std::iter::from_fn(|| source.next_frame()).filter(|frame| frame.picture.is_ok()).count();
        assert_eq!((pictures, source.kind()), (3, "mcap"), "{}", file.display());
    }
}

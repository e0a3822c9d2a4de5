use super::*;
use crate::asset::Slot;
use crate::error::ErrorCode;
use crate::pipeline::tests::noise_asset;
use crate::pipeline::{Limits, Product, convert_read};
use crate::watch::Unwatched;

fn options(settings: &[(&str, &str)]) -> Options {
    let mut options = Options::default();
    settings.iter().for_each(|(name, value)| options.set(name, value).unwrap());
    options
}

#[test]
fn blocks_are_reported_beside_what_was_before_and_change_nothing_else() {
    let asset = noise_asset(3, 6, Slot::BaseColor);
    // Levels in a range of their own come with 4D coordinates alone.
    for (coordinates, has_ranges) in [("4d-rows", true), ("indexed", false)] {
        let convert = |settings: &[(&str, &str)]| {
            let always = [("textures", "ktx2"), ("cut", "255"), ("coordinates", coordinates)];
            let options = options(&[&always, settings].concat());
            convert_read(&asset, &options, &Limits::default(), &Unwatched).unwrap()
        };
        let plain = convert(&[]);
        let blocks = convert(&[("compress", "bc7,bc6h")]);
        assert!(plain.report.compression.is_empty());
        assert!(plain.files[0] == blocks.files[0] && plain.finished == blocks.finished);
        assert_eq!(plain.report.channels, blocks.report.channels);
        assert_eq!(has_ranges, !blocks.finished.textures[0].ranges.is_empty());
        assert_blocks_are_told(&blocks);
    }
}

fn assert_blocks_are_told(blocks: &Product) {
    let [channel] = &blocks.report.compression[..] else { panic!("one channel") };
    let texture = &blocks.finished.textures[0];
    assert_eq!(channel.slots, ["baseColorTexture"]);
    assert_eq!(channel.levels.len(), texture.levels.len());
    for level in &channel.levels {
        let number = level.level as usize;
        let is_ranged = texture.ranges.contains_key(&number);
        assert_eq!(level.format, if is_ranged { "bc6h" } else { "bc7" });
        let [width, height] = texture.levels[number].size().map(|side| u64::from(side.next_multiple_of(4)));
        assert_eq!(level.bytes, width * height);
        assert_eq!(level.seams_before, blocks.report.channels[0].levels[number].seams);
        let [before, unfitted, fitted] =
            [level.seams_before, level.seams_unfitted, level.seams].map(|seams| seams.unwrap().mean);
        assert!(unfitted >= before && level.psnr_db > 15.0 && level.psnr_db <= 99.0, "{level:?}");
        assert!(if level.is_refitted { fitted < unfitted } else { fitted == unfitted }, "{level:?}");
    }
    assert!(channel.levels.iter().any(|level| level.is_refitted));
}

#[test]
fn blocks_without_files_are_refused_before_anything_is_done() {
    let asset = noise_asset(3, 2, Slot::BaseColor);
    let refused = convert_read(&asset, &options(&[("compress", "bc7")]), &Limits::default(), &Unwatched);
    let error = refused.map(|_| ()).unwrap_err();
    assert_eq!((error.code, error.pointer.as_deref()), (ErrorCode::InvalidOptions, Some("/compress")));
}

//! The curve of figures made by hand.

use super::*;

fn map(slot: &str, psnr_db: f64, yardstick_psnr_db: f64) -> MapError {
    MapError { material: 0, slots: vec![slot.to_owned()], psnr_db, yardstick_psnr_db }
}

fn figures(texels: u64, maps: Vec<MapError>) -> Figures {
    Figures { texels, stored_face_count: 100, source_texels: Some(4096), maps }
}

fn curve(points: Vec<PointEnd>) -> Curve {
    let point = |end| Point { share: 0.25, options: Map::new(), end };
    let line = Line { name: "budget, fitted".to_owned(), points: points.into_iter().map(point).collect() };
    Curve { source_texels: None, stored_face_count: 100, cpu_seconds: 1.0, lines: vec![line] }
}

#[test]
fn gains_are_over_all_maps_and_colors_are_one_picture() {
    let maps = vec![
        map("normalTexture", 50.0, 45.0),
        map("baseColorTexture", 40.0, 41.0),
        map("baseColorTexture", 30.0, 31.0),
    ];
    let figures = figures(1000, maps);
    let [mean, least, most] = figures.gains_db().unwrap();
    assert!((mean - 1.0).abs() < 1e-9 && (least, most) == (-1.0, 5.0));
    let [ours, plain] = figures.color_psnr_db().unwrap();
    // Half of the picture has a tenth of the other half's error.
    assert!((ours - (30.0 - 10.0 * 0.55f64.log10())).abs() < 1e-9, "{ours}");
    assert!((plain - ours - 1.0).abs() < 1e-9);
    assert!(super::Figures { maps: Vec::new(), ..figures }.gains_db().is_none());
}

#[test]
fn the_headline_leaves_out_what_is_down_to_corners() {
    let done =
        |texels, gain| PointEnd::Done(figures(texels, vec![map("baseColorTexture", 40.0 + gain, 40.0)]));
    let refused = PointEnd::Refused { code: "x".to_owned(), reason: "too | few".to_owned() };
    let curve = curve(vec![refused, done(400, -9.0), done(401, 1.0), done(800, -0.5)]);
    let wanted = "Nearer than plain resampling up to 401 texels, by up to 1.0 dB; 0.5 dB under it at 800";
    assert_eq!(headline(&curve).unwrap(), wanted);
    let table = table(&curve);
    assert!(
        table.contains("| refused: too \\| few |") && table.contains("| 401 | 4.0 | 41.0 | 40.0 | +1.0 |"),
        "{table}"
    );
}

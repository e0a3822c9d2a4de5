use super::*;

fn transferred(source: &Asset, target: &Asset, finer: u8) -> (Asset, TransferReport) {
    let edited = transfer(source, None, target, finer, &Limits::default(), &Unwatched).unwrap();
    (reread(&edited), edited.report.transfer.unwrap())
}

/// The box without paint.
fn bare(mut asset: Asset) -> Asset {
    asset.materials[0].mesh_colors = None;
    asset
}

#[test]
fn a_model_painted_from_its_own_shape_shows_the_same() {
    let mut asset = painted_box(2);
    // Without a cut, which a transfer cannot see.
    for seed in 2..100 {
        asset = painted_box(seed);
        if painting(&asset).channels[0].cuts.edges.iter().all(|cut| !*cut) {
            break;
        }
    }
    let up = resolution(&asset, &Selection::default(), change(1), &Limits::default(), &Unwatched).unwrap();
    let (_, coarse) = transferred(&reread(&up), &bare(asset.clone()), 0);
    let (painted, fine) = transferred(&reread(&up), &bare(asset.clone()), 4);
    assert!(fine.distance_max < 1e-6, "{fine:?}");
    assert!((fine.source_diagonal - DVec3::new(1.0, 1.5, 2.0).length()).abs() < 1e-6);
    for (coarse, fine) in coarse.channels.iter().zip(&fine.channels) {
        // Random values from sample to sample: only far more samples than the source has show them.
        assert!(fine.on_source_rms < 0.4 * coarse.on_source_rms, "{fine:?} {coarse:?}");
        assert!(fine.on_target_rms < 2.0, "{fine:?}");
    }
    assert_eq!(paintings(&painted).unwrap().len(), 1);
}

#[test]
fn smooth_pictures_come_over_almost_as_they_are() {
    // Color is place, which is linear on every face; the other model is the same one, subdivided.
    let mut asset = painted_box(0);
    let own = painting(&asset);
    let mut colors = asset.materials[0].mesh_colors.clone().unwrap();
    let side = Side::new(&asset, &own.canvas);
    for (channel, painted) in colors.channels.iter_mut().zip(&own.channels) {
        let places = spots(&own.numbering(painted, 0));
        let value = |spot| side.point(spot).as_vec3() * Vec3::new(1.0, 1.0 / 1.5, 0.5);
        let values: Vec<Vec4> = places.iter().map(|spot| value(spot).extend(1.0)).collect();
        channel.samples = painted.with(&values, Vec::new(), Vec::new()).samples;
    }
    asset.materials[0].mesh_colors = Some(colors);
    let target = reread(&subdivide(&asset, Scheme::Midpoint, &Limits::default(), &Unwatched).unwrap());
    let (_, report) = transferred(&asset, &bare(target), 0);
    for channel in &report.channels {
        assert!(channel.on_target_max < 0.01 && channel.on_source_max < 0.01, "{channel:?}");
    }
}

#[test]
fn triangles_get_partners_and_samples_stay_in_range() {
    // White all over: interpolated it may come out above 1.
    let mut asset = painted_box(0);
    let colors = asset.materials[0].mesh_colors.as_mut().unwrap();
    colors.channels.iter_mut().for_each(|channel| channel.samples.fill(1.0));
    let mut target = bare(asset.clone());
    let faces = &mut target.meshes[0].primitives[0].faces;
    let halves = |face: &Face| {
        let [a, b, c, d] = face.corners;
        let pair = [[a, b, c], [a, c, d]].map(Face::triangle);
        pair.into_iter().take(usize::from(face.count) - 2)
    };
    *faces = faces.iter().flat_map(halves).collect();
    let count = faces.len();
    let (painted, _) = transferred(&asset, &target, 1);
    let colors = painted.materials[0].mesh_colors.as_ref().or(painted.materials[1].mesh_colors.as_ref());
    let colors = colors.unwrap();
    assert_eq!(colors.partners.len(), count);
    assert!(colors.partners.iter().flatten().count() > count / 2, "{:?}", colors.partners);
    assert!(colors.channels.iter().flat_map(|channel| &channel.samples).all(|value| *value <= 1.0));
}

#[test]
fn what_is_missing_for_a_transfer_is_said() {
    let asset = painted_box(0);
    let run = |source: &Asset, material, target: &Asset, limits: &Limits| {
        transfer(source, material, target, 0, limits, &Unwatched).unwrap_err()
    };
    let standard = Limits::default();
    assert!(run(&asset, Some(4), &asset, &standard).detail.contains("which painted material is meant: 0"));
    assert!(run(&asset, None, &Asset::default(), &standard).detail.contains("no faces"));
    let few = Limits { job_pixels: 10, ..Limits::default() };
    assert_eq!(run(&asset, None, &bare(asset.clone()), &few).code, ErrorCode::ModelTooLarge);
    let mut flat = asset.clone();
    flat.meshes[0].primitives[0].positions.fill(Vec3::ZERO);
    assert_eq!(run(&flat, None, &asset, &standard).code, ErrorCode::InvalidModel);
}

#[test]
fn the_nearest_point_is_found() {
    let asset = painted_box(0);
    let own = painting(&asset);
    let side = Side::new(&asset, &own.canvas);
    let surface = Surface::new(&own.canvas, &side.positions);
    let mut random = Random(7);
    for _ in 0..500 {
        let point = DVec3::from_array([0; 3].map(|_| f64::from(random.unit()) * 4.0 - 1.0));
        let found = surface.nearest(&own.canvas, point).unwrap();
        // Of a box without looking at faces.
        let size = DVec3::new(1.0, 1.5, 2.0);
        let outside = (point - point.clamp(DVec3::ZERO, size)).length();
        let inside = point.min(size - point).min_element();
        let wanted = if outside > 0.0 { outside } else { inside };
        assert!((found.distance - wanted).abs() < 1e-9, "{point} {found:?} {wanted}");
        let spot = super::super::side::Spot { face: found.face, at: found.at.to_array() };
        assert!((side.point(&spot) - point).length() - wanted < 1e-6);
    }
}

use super::*;

#[test]
fn told_defaults_are_the_defaults() {
    for spec in OPTIONS {
        let mut options = Options::default();
        options.set(spec.name, spec.default).unwrap();
        assert_eq!(options, Options::default(), "{}", spec.name);
    }
}

#[test]
fn rungs_are_values_that_are_told_and_read_back() {
    for spec in OPTIONS {
        for rung in spec.rungs {
            let mut options = Options::default();
            options.set(spec.name, rung).unwrap();
            assert_eq!(options.to_json()[spec.name], *rung);
            assert!(spec.allowed.contains(rung), "{} does not tell {rung}", spec.name);
        }
        let is_ladder = spec.name != "quality" && spec.name != "resolution" && spec.follows_quality;
        assert_eq!(is_ladder || spec.name == "quality", !spec.rungs.is_empty(), "{}", spec.name);
    }
}

#[test]
fn loose_textures_are_a_list_without_jpeg() {
    let mut options = Options::default();
    for (value, told) in [("exr, png,exr", "png,exr"), ("ktx2", "ktx2"), ("none", "none")] {
        options.set("textures", value).unwrap();
        assert_eq!(options.to_json()["textures"], told);
        assert_eq!(Options::from_json(&options.to_json()).unwrap(), options);
    }
    options.set("textures", "exr").unwrap();
    options.set("quality", "draft").unwrap();
    assert_eq!(options.textures, BTreeSet::from([TextureFormat::Exr]));
    for value in ["jpeg", "png,jpg"] {
        let error = options.set("textures", value).unwrap_err();
        assert!(error.detail.contains("seams would come back"), "{error}");
        assert_eq!(error.pointer.as_deref(), Some("/textures"));
    }
    for value in ["", "png,", "png,none", "PNG", "webp"] {
        let error = options.set("textures", value).unwrap_err();
        assert!(error.detail.contains("allowed: none") && !error.detail.contains("JPEG"), "{error}");
    }
    assert_eq!(options.textures, BTreeSet::from([TextureFormat::Exr]));
}

#[test]
fn blocks_need_files_that_hold_them() {
    let mut options = Options::default();
    options.set("compress", "bc6h,bc7,bc5").unwrap();
    assert_eq!(options.to_json()["compress"], "bc5,bc6h,bc7");
    let error = options.check().unwrap_err();
    assert_eq!(error.pointer.as_deref(), Some("/compress"));
    assert!(error.detail.contains("add ktx2 to textures"), "{error}");
    assert_eq!(Options::from_json(&options.to_json()).unwrap_err(), error);
    options.set("textures", "png,ktx2").unwrap();
    options.check().unwrap();
    assert_eq!(Options::from_json(&options.to_json()).unwrap(), options);
    for value in ["", "bc7,astc", "bc1", "none,bc7"] {
        assert!(options.set("compress", value).unwrap_err().detail.contains("allowed: none"));
    }
}

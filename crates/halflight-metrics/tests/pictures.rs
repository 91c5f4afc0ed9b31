//! Error maps, tone mapping and files.

#![allow(clippy::unwrap_used, reason = "a helper of a test may fail it")]

use std::{
    fs,
    path::{Path, PathBuf},
};

use glam::Vec3;
use halflight_metrics::{CompareError, Image, error_map, squared_error_picture, tone_map, write_png};

/// Creates an empty folder for one test.
fn folder(name: &str) -> PathBuf {
    let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    if path.exists() {
        fs::remove_dir_all(&path).unwrap();
    }
    fs::create_dir_all(&path).unwrap();
    path
}

fn names(folder: &Path) -> Vec<String> {
    fs::read_dir(folder).unwrap().map(|e| e.unwrap().file_name().into_string().unwrap()).collect()
}

#[test]
fn error_maps_show_the_difference_where_it_is() {
    let reference = [Vec3::splat(4.0), Vec3::splat(2.0), Vec3::ONE, Vec3::NAN];
    let image = [Vec3::splat(4.0), Vec3::splat(1.0), Vec3::splat(2.0), Vec3::ZERO];
    let mask = [true, true, true, false];
    let reference = Image::new(2, 2, &reference).unwrap().with_mask(&mask).unwrap();
    let image = Image::new(2, 2, &image).unwrap();
    let map = error_map(image, reference).unwrap();
    assert_eq!((map.width, map.height), (2, 2));
    assert_eq!(map.values, [Some(0.0), Some(0.25), Some(0.25), None]);

    let [zero, some, same, masked] = map.picture(0.5)[..] else { panic!("four pixels") };
    assert_eq!(some, same);
    assert!(zero != some && masked != zero && masked != some);
    // The scale is fixed by the caller: half of it shows the same error at the end of the ramp, where all
    // beyond is.
    let end = map.picture(0.25)[1];
    assert_ne!(end, some);
    assert_eq!(map.picture(0.1)[1], end);

    let red = squared_error_picture(image, reference, 1.0).unwrap();
    // 3 · 0.25² · 255 = 47.8.
    assert_eq!(red, [[0, 0, 0], [48, 0, 0], [48, 0, 0], [0, 0, 0]]);
    assert_eq!(squared_error_picture(image, reference, 9.0).unwrap()[1], [255, 0, 0]);
}

#[test]
fn error_maps_refuse_what_cannot_be_compared() {
    let pixels = [Vec3::ONE; 2];
    let (row, column) = (Image::new(2, 1, &pixels).unwrap(), Image::new(1, 2, &pixels).unwrap());
    assert!(matches!(error_map(row, column), Err(CompareError::Shape(_))));
    assert!(matches!(squared_error_picture(row, column, 1.0), Err(CompareError::Shape(_))));
}

#[test]
fn tone_mapping_is_srgb_with_a_fixed_exposure() {
    // Known pairs of the sRGB transfer function: 0.2140 is 50 % (127.5), 0.0031308 the end of its linear
    // part.
    let linear = [Vec3::new(0.0, 1.0, 0.214_041_14), Vec3::new(0.003_130_8, -1.0, 9.0), Vec3::NAN];
    assert_eq!(tone_map(&linear[..1], 1.0)[0][..2], [0, 255]);
    assert!((127..=128).contains(&tone_map(&linear, 1.0)[0][2]));
    assert_eq!(tone_map(&linear, 1.0)[1..], [[10, 0, 255], [0, 0, 0]]);
    assert_eq!(tone_map(&[Vec3::splat(0.25)], 4.0), [[255; 3]]);
    assert_eq!(tone_map(&[Vec3::splat(0.25)], 2.0), tone_map(&[Vec3::splat(0.5)], 1.0));
}

#[test]
fn png_files_read_back_as_they_were() {
    let folder = folder("png");
    let path = folder.join("picture.png");
    let rgb: Vec<[u8; 3]> = (0..6).map(|i| [i, 2 * i, 255 - i]).collect();
    write_png(&path, 3, 2, &rgb).unwrap();
    // Writing over an existing file replaces it.
    write_png(&path, 2, 3, &rgb).unwrap();
    let read = image::open(&path).unwrap().into_rgb8();
    assert_eq!((read.width(), read.height()), (2, 3));
    assert_eq!(read.as_raw()[..], *rgb.as_flattened());
    assert_eq!(names(&folder), ["picture.png"]);
}

#[test]
fn failed_writes_leave_nothing_behind() {
    let folder = folder("failed");
    let path = folder.join("kept.png");
    fs::write(&path, "before").unwrap();
    let error = write_png(&path, 3, 3, &[[0; 3]; 6]).unwrap_err();
    assert!(error.to_string().contains("kept.png"), "{error}");
    assert_eq!(error.source.to_string(), "a picture of 3×3 cannot be made of 6 pixels");
    assert!(write_png(&path, 0, 3, &[]).is_err());
    assert_eq!(fs::read(&path).unwrap(), b"before");
    assert_eq!(names(&folder), ["kept.png"]);

    // Path that is a folder, and path in a missing folder.
    let taken = folder.join("taken");
    fs::create_dir_all(taken.join("inside")).unwrap();
    assert!(write_png(&taken, 1, 1, &[[0; 3]]).is_err());
    assert!(write_png(&folder.join("missing").join("a.png"), 1, 1, &[[0; 3]]).is_err());
    assert!(write_png(Path::new("/"), 1, 1, &[[0; 3]]).is_err());
    assert_eq!(names(&folder).len(), 2);
}

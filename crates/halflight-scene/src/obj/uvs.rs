//! Scale and offset of textures, applied to texture coordinates.

use std::collections::HashMap;

use crate::model::ModelMesh;
use crate::mtl::UvTransform;

/// Applies the transforms of the mesh's materials to the texture coordinates of their faces. A vertex shared
/// by materials of different transforms is split.
pub(super) fn apply(mesh: &mut ModelMesh, transforms: &[UvTransform]) {
    const NONE: u32 = u32::MAX;
    if transforms.iter().all(UvTransform::is_identity) {
        return;
    }
    // Materials with the same transform share vertices.
    let mut known = HashMap::new();
    let class: Vec<u32> = (0..)
        .zip(transforms)
        .map(|(material, transform)| *known.entry(transform.bits()).or_insert(material))
        .collect();
    let mut owner = vec![NONE; mesh.positions.len()];
    let mut splits = HashMap::new();
    let mut faces = std::mem::take(&mut mesh.faces);
    let mut runs = mesh.runs.iter().peekable();
    let mut current = 0;
    for (number, corners) in faces.iter_mut().enumerate() {
        while let Some(&(_, material)) = runs.next_if(|(start, _)| *start <= number) {
            current = material;
        }
        let class = class[current as usize];
        for vertex in corners {
            let current = *vertex as usize;
            if owner[current] == NONE {
                owner[current] = class;
            } else if owner[current] != class {
                *vertex = *splits.entry((class, *vertex)).or_insert_with(|| {
                    mesh.positions.push(mesh.positions[current]);
                    mesh.normals.push(mesh.normals[current]);
                    mesh.uvs.push(mesh.uvs[current]);
                    owner.push(class);
                    (owner.len() - 1) as u32
                });
            }
        }
    }
    mesh.faces = faces;
    for (uv, &class) in mesh.uvs.iter_mut().zip(&owner) {
        if let Some(transform) = transforms.get(class as usize) {
            *uv = *uv * transform.scale + transform.offset;
        }
    }
}

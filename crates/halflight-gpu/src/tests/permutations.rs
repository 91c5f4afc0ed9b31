use naga::back::pipeline_constants::process_overrides;
use naga::back::{hlsl, msl};
use naga::front::wgsl;
use naga::valid::{Capabilities, ValidationFlags, Validator};

use crate::bindings::{Access, Slot};
use crate::gpu::WORKGROUP_BYTES;
use crate::program::Program;
use crate::shader::{Shader, module_names, shader_module};
use crate::{compose, emission, gbuffer, present, refine, specular, textured, upsample, visibility};

/// Returns the programs of all stages.
fn all() -> impl Iterator<Item = &'static Program> {
    let single = [
        compose::PROGRAMS,
        emission::PROGRAMS,
        gbuffer::PROGRAMS,
        present::PROGRAMS,
        specular::PROGRAMS,
        textured::PROGRAMS,
        upsample::PROGRAMS,
    ];
    single.into_iter().chain(refine::PROGRAMS.iter().chain(visibility::PROGRAMS).copied()).flatten()
}

/// Returns the program of a name.
pub(super) fn named(name: &str) -> Program {
    *all().find(|program| program.name == name).unwrap()
}

#[test]
fn every_module_belongs_to_a_program() {
    let texts: Vec<String> = all().map(|program| Shader::new(program, &[]).unwrap().text).collect();
    for name in module_names() {
        let module = shader_module(name).unwrap();
        assert!(texts.iter().any(|text| text.contains(&*module)), "{name}");
    }
}

/// Parses a program by naga.
pub(super) fn parsed(program: &Program) -> (naga::Module, Vec<(Slot, Access)>) {
    let Shader { text, slots } = Shader::new(program, &[]).unwrap();
    let module = wgsl::parse_str(&text);
    (module.unwrap_or_else(|e| panic!("{}: {}", program.name, e.emit_to_string(&text))), slots)
}

#[test]
fn every_program_is_valid_and_binds_what_it_says() {
    for program in all() {
        let (module, slots) = parsed(program);
        let mut validator = Validator::new(ValidationFlags::all(), Capabilities::empty());
        let info = validator.validate(&module).unwrap_or_else(|error| panic!("{}: {error:?}", program.name));
        let index = module.entry_points.iter().position(|entry| entry.name == program.entry).unwrap();
        let used = info.get_entry_point(index);
        let mut shared = 0;
        for (handle, global) in module.global_variables.iter() {
            if global.space == naga::AddressSpace::WorkGroup {
                shared += u64::from(module.types[global.ty].inner.size(module.to_ctx()));
            }
            // The uniform is bound for all.
            let Some(binding) = global.binding.filter(|binding| binding.binding > 0) else { continue };
            let usage = used[handle];
            assert!(!usage.is_empty(), "{} does not use {:?}", program.name, global.name);
            let known = slots.iter().find(|(slot, _)| slot.binding() == binding.binding);
            if let Some((slot, Access::Write)) = known {
                let writes = usage.contains(naga::valid::GlobalUse::WRITE);
                let atomic = matches!(
                    global.name.as_deref(),
                    Some("bins" | "counters" | "large" | "pyramid" | "seen" | "spilled" | "voxels")
                );
                assert!(writes || atomic, "{} only reads {slot:?}", program.name);
            }
        }
        assert!(shared <= WORKGROUP_BYTES, "{} shares {shared} bytes", program.name);
    }
}

/// Neither Direct3D nor Metal runs here; that wgpu can translate every program for them is known.
#[test]
fn every_program_is_translated_for_direct3d_and_metal() {
    for program in all() {
        let (module, _) = parsed(program);
        let mut validator = Validator::new(ValidationFlags::all(), Capabilities::empty());
        let info = validator.validate(&module).unwrap();
        let (module, info) =
            process_overrides(&module, &info, None, &naga::back::PipelineConstants::default()).unwrap();
        let options = hlsl::Options { shader_model: hlsl::ShaderModel::V6_0, ..hlsl::Options::default() };
        let mut text = String::new();
        let usual = hlsl::PipelineOptions::default();
        let found = hlsl::Writer::new(&mut text, &options, &usual).write(&module, &info, None).unwrap();
        assert!(found.entry_point_names.iter().all(Result::is_ok), "{}: {found:?}", program.name);
        assert!(text.contains(program.entry), "{}", program.name);
        let options = msl::Options { lang_version: (2, 4), ..msl::Options::default() };
        let usual = msl::PipelineOptions::default();
        let (text, found) = msl::write_string(&module, &info, &options, &usual).unwrap();
        assert!(found.entry_point_names.iter().all(Result::is_ok), "{}: {found:?}", program.name);
        assert!(text.contains(program.entry), "{}", program.name);
    }
}

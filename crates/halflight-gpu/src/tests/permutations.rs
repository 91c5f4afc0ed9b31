use naga::front::wgsl;
use naga::valid::{Capabilities, ValidationFlags, Validator};

use crate::bindings::{Access, Slot};
use crate::gpu::WORKGROUP_BYTES;
use crate::programs::{ALL, Program};
use crate::shader::Shader;

/// A program as naga sees it.
pub(super) fn parsed(program: &Program) -> (naga::Module, Vec<(Slot, Access)>) {
    let Shader { text, slots } = Shader::new(program, &[]).unwrap();
    let module = wgsl::parse_str(&text);
    (module.unwrap_or_else(|e| panic!("{}: {}", program.name, e.emit_to_string(&text))), slots)
}

#[test]
fn every_program_is_valid_and_binds_what_it_says() {
    for program in ALL {
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

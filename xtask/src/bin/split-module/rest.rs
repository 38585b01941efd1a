//! The second part: the functions for which the first has only stubs. Everything else it imports
//! from the first.

use std::collections::{BTreeMap, BTreeSet};
use std::hash::{DefaultHasher, Hash, Hasher};

use anyhow::Result;
use walrus::ir::Value;
use walrus::{
    ConstExpr, ElementItems, ElementKind, FunctionKind, GlobalKind, ImportedFunction, Module,
};

use crate::numbers::{Numbers, local};
use crate::parts::Plan;

/// The module from which the rest imports.
const FIRST: &str = "first";

/// The name under which the first part exports a function.
pub(crate) fn name(number: usize) -> String {
    format!("f{number}")
}

/// Functions of the first part that have at most this many instructions are copied into the second,
/// because calls within a module are faster.
const SMALL: u64 = 40;

/// The part, and the functions that the first part has to export for it.
pub(crate) fn rest(bytes: &[u8], plan: &Plan) -> Result<(Vec<u8>, Vec<usize>)> {
    let mut module = Module::from_buffer(bytes)?;
    let numbers = Numbers::of(&module);
    let (mut own, mut asked) = (plan.deferred.clone(), BTreeSet::new());
    let mut waiting: Vec<usize> = own.iter().copied().collect();
    while let Some(number) = waiting.pop() {
        for callee in numbers.callees(&module, number) {
            let id = numbers.id(callee);
            if own.contains(&callee) || asked.contains(&callee) {
                continue;
            }
            if local(&module, id).is_some_and(|local| local.size() <= SMALL) {
                own.insert(callee);
                waiting.push(callee);
            } else {
                asked.insert(callee);
            }
        }
    }
    for &number in &asked {
        import_function(&mut module, &numbers, number);
    }
    import_shared(&mut module, bytes, plan);
    let exports: Vec<_> = module.exports.iter().map(walrus::Export::id).collect();
    exports.into_iter().for_each(|id| module.exports.delete(id));
    module.start = None;
    let elements: Vec<_> = module.elements.iter().map(walrus::Element::id).collect();
    elements
        .into_iter()
        .for_each(|id| module.elements.delete(id));
    let data: Vec<_> = module.data.iter().map(walrus::Data::id).collect();
    data.into_iter().for_each(|id| module.data.delete(id));
    fill_table(&mut module, &numbers, plan)?;
    walrus::passes::gc::run(&mut module);
    Ok((module.emit_wasm(), asked.into_iter().collect()))
}

fn import_function(module: &mut Module, numbers: &Numbers, number: usize) {
    let id = numbers.id(number);
    if let FunctionKind::Import(function) = &module.funcs.get(id).kind {
        let import = module.imports.get_mut(function.import);
        (import.module, import.name) = (FIRST.into(), name(number));
        return;
    }
    let ty = module.funcs.get(id).ty();
    let import = module.imports.add(FIRST, &name(number), id);
    module.funcs.get_mut(id).kind = FunctionKind::Import(ImportedFunction { import, ty });
}

/// The name under which the first part exports a memory. It contains a hash of the original module,
/// which prevents parts of two modules from being joined.
fn name_of_memory(at: usize, bytes: &[u8]) -> String {
    let mut hasher = DefaultHasher::new();
    bytes.hash(&mut hasher);
    format!("m{at} {:016x}", hasher.finish())
}

/// Exports memory, tables and globals, by kind and number. `bytes`: the original module.
pub(crate) fn export_shared(module: &mut Module, bytes: &[u8]) {
    let memories: Vec<_> = module.memories.iter().map(walrus::Memory::id).collect();
    for (at, id) in memories.into_iter().enumerate() {
        module.exports.add(&name_of_memory(at, bytes), id);
    }
    let tables: Vec<_> = module.tables.iter().map(walrus::Table::id).collect();
    for (at, id) in tables.into_iter().enumerate() {
        module.exports.add(&format!("t{at}"), id);
    }
    let globals: Vec<_> = module.globals.iter().map(walrus::Global::id).collect();
    for (at, id) in globals.into_iter().enumerate() {
        module.exports.add(&format!("g{at}"), id);
    }
}

fn import_shared(module: &mut Module, bytes: &[u8], plan: &Plan) {
    let memories: Vec<_> = module.memories.iter().map(walrus::Memory::id).collect();
    for (at, id) in memories.into_iter().enumerate() {
        let import = module.imports.add(FIRST, &name_of_memory(at, bytes), id);
        let memory = module.memories.get_mut(id);
        memory.import = Some(import);
        memory.data_segments.clear();
    }
    let main = module.tables.main_function_table().ok().flatten();
    let tables: Vec<_> = module.tables.iter().map(walrus::Table::id).collect();
    for (at, id) in tables.into_iter().enumerate() {
        let import = module.imports.add(FIRST, &format!("t{at}"), id);
        let table = module.tables.get_mut(id);
        table.import = Some(import);
        table.elem_segments.clear();
        if Some(id) == main {
            table.initial = plan.table_length;
            table.maximum = table.maximum.map(|maximum| maximum.max(plan.table_length));
        }
    }
    let globals: Vec<_> = module.globals.iter().map(walrus::Global::id).collect();
    for (at, id) in globals.into_iter().enumerate() {
        let import = module.imports.add(FIRST, &format!("g{at}"), id);
        module.globals.get_mut(id).kind = GlobalKind::Import(import);
    }
}

/// Puts the functions into their table slots.
fn fill_table(module: &mut Module, numbers: &Numbers, plan: &Plan) -> Result<()> {
    let Some(table) = module.tables.main_function_table()? else {
        return Ok(());
    };
    let by_place: BTreeMap<u64, usize> = plan.places.iter().map(|(&n, &at)| (at, n)).collect();
    let mut runs: Vec<(u64, Vec<walrus::FunctionId>)> = vec![];
    for (place, number) in by_place {
        let id = numbers.id(number);
        match runs.last_mut() {
            Some((begin, run)) if *begin + run.len() as u64 == place => run.push(id),
            _ => runs.push((place, vec![id])),
        }
    }
    for (begin, run) in runs {
        let offset = ConstExpr::Value(Value::I32(i32::try_from(begin)?));
        let kind = ElementKind::Active { table, offset };
        let element = module.elements.add(kind, ElementItems::Functions(run));
        module.tables.get_mut(table).elem_segments.insert(element);
    }
    Ok(())
}

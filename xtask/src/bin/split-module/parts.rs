//! The first part: functions that were called, and a stub for each other function that can be
//! called from outside the rest.
//!
//! Both parts share memory, globals and table. A stub calls through a slot of the table, in which
//! the rest puts the function itself when it is loaded; if it is not loaded yet, the stub loads it
//! first. So a function behaves the same in either part, and code is moved without being changed.

use std::collections::{BTreeMap, BTreeSet};

use anyhow::{Context, Result, bail};
use walrus::ir::{UnaryOp, Value};
use walrus::{
    ConstExpr, ElementKind, ExportItem, FunctionBuilder, FunctionId, FunctionKind, GlobalId,
    Module, TableId, ValType,
};

use crate::numbers::{Numbers, functions, local};
use crate::rest;

/// The function that loads the rest; it returns when that is done.
const LOAD: &str = "load_rest";
/// The function that wasm-bindgen calls when the module is instantiated.
const START: &str = "__wbindgen_start";
/// The global that is 1 once the rest is loaded. The loader sets it.
const IS_LOADED: &str = "rest_is_loaded";

pub(crate) struct Parts {
    pub(crate) first: Vec<u8>,
    pub(crate) rest: Vec<u8>,
}

/// Which function is in which part.
pub(crate) struct Plan {
    /// Functions in the rest; the others are in the first part.
    pub(crate) deferred: BTreeSet<usize>,
    /// The table slot of each function that can be called from outside the rest.
    pub(crate) places: BTreeMap<usize, u64>,
    /// The new length of the table.
    pub(crate) table_length: u64,
}

pub(crate) fn split(bytes: &[u8], called: &[usize]) -> Result<Parts> {
    let mut module = Module::from_buffer(bytes)?;
    let numbers = Numbers::of(&module);
    let table = module
        .tables
        .main_function_table()?
        .context("the module has no table of functions")?;
    let plan = plan(&module, &numbers, table, called)?;
    let (rest, asked) = rest::rest(bytes, &plan)?;

    let load = exported(&module, LOAD)?;
    let is_loaded = add_flag(&mut module);
    module.tables.get_mut(table).initial = plan.table_length;
    if let Some(maximum) = &mut module.tables.get_mut(table).maximum {
        *maximum = plan.table_length.max(*maximum);
    }
    for &number in &plan.deferred {
        let id = numbers.id(number);
        let place = plan.places.get(&number);
        stub(
            &mut module,
            id,
            place.map(|&place| Jump {
                place,
                table,
                load,
                is_loaded,
            }),
        );
    }
    for number in asked {
        module.exports.add(&rest::name(number), numbers.id(number));
    }
    rest::export_shared(&mut module, bytes);
    walrus::passes::gc::run(&mut module);
    Ok(Parts {
        first: module.emit_wasm(),
        rest,
    })
}

fn exported(module: &Module, name: &str) -> Result<FunctionId> {
    let export = module.exports.iter().find(|export| export.name == name);
    match export.map(|export| &export.item) {
        Some(ExportItem::Function(id)) => Ok(*id),
        _ => bail!("the module exports no function {name}"),
    }
}

fn plan(module: &Module, numbers: &Numbers, table: TableId, called: &[usize]) -> Result<Plan> {
    let mut stays: BTreeSet<usize> = called.iter().copied().collect();
    stays.insert(numbers.number(exported(module, LOAD)?));
    // What runs during instantiation, when the rest cannot be loaded yet.
    let mut first: Vec<usize> = module
        .start
        .map(|id| numbers.number(id))
        .into_iter()
        .collect();
    first.extend(exported(module, START).map(|id| numbers.number(id)));
    let mut seen = BTreeSet::new();
    while let Some(number) = first.pop() {
        if seen.insert(number) {
            first.extend(numbers.callees(module, number));
        }
    }
    stays.append(&mut seen);
    let deferred: BTreeSet<usize> = (0..numbers.len())
        .filter(|number| !stays.contains(number))
        .filter(|&number| local(module, numbers.id(number)).is_some())
        .collect();

    let mut places = BTreeMap::new();
    for element in module.elements.iter() {
        let ElementKind::Active { table: of, offset } = &element.kind else {
            bail!("a segment of the table is not active");
        };
        let ConstExpr::Value(Value::I32(offset)) = offset else {
            bail!("a segment of the table has no constant place");
        };
        let offset = u64::try_from(*offset)?;
        for (at, id) in functions(&element.items).into_iter().enumerate() {
            let number = id.map(|id| numbers.number(id));
            if let Some(number) = number.filter(|number| *of == table && deferred.contains(number))
            {
                places.entry(number).or_insert(offset + at as u64);
            }
        }
    }
    let exports = module
        .exports
        .iter()
        .filter_map(|export| match export.item {
            ExportItem::Function(id) => Some(numbers.number(id)),
            _ => None,
        });
    let mut entries: BTreeSet<usize> = exports.collect();
    for number in (0..numbers.len()).filter(|number| !deferred.contains(number)) {
        entries.append(&mut numbers.callees(module, number));
    }
    let mut table_length = module.tables.get(table).initial;
    for number in entries
        .into_iter()
        .filter(|number| deferred.contains(number))
    {
        places.entry(number).or_insert_with(|| {
            table_length += 1;
            table_length - 1
        });
    }
    Ok(Plan {
        deferred,
        places,
        table_length,
    })
}

fn add_flag(module: &mut Module) -> GlobalId {
    let no = ConstExpr::Value(Value::I32(0));
    let flag = module.globals.add_local(ValType::I32, true, false, no);
    module.exports.add(IS_LOADED, flag);
    flag
}

/// Where a stub continues.
struct Jump {
    place: u64,
    table: TableId,
    load: FunctionId,
    is_loaded: GlobalId,
}

/// Replaces the body of a function; a function that is not called from outside the rest gets an
/// empty one.
fn stub(module: &mut Module, id: FunctionId, jump: Option<Jump>) {
    let ty = module.funcs.get(id).ty();
    let (params, results) = module.types.params_results(ty);
    let (params, results) = (params.to_vec(), results.to_vec());
    let args: Vec<_> = params.iter().map(|&ty| module.locals.add(ty)).collect();
    let mut builder = FunctionBuilder::new(&mut module.types, &params, &results);
    let mut body = builder.func_body();
    if let Some(jump) = jump {
        body.global_get(jump.is_loaded)
            .unop(UnaryOp::I32Eqz)
            .if_else(
                None,
                |then| {
                    then.call(jump.load);
                },
                |_| {},
            );
        for &arg in &args {
            body.local_get(arg);
        }
        body.i32_const(jump.place as i32)
            .call_indirect(ty, jump.table);
    } else {
        body.unreachable();
    }
    module.funcs.get_mut(id).kind = FunctionKind::Local(builder.local_func(args));
}

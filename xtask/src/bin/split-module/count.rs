//! The module with a global for each function, which the function sets when it is called.

use anyhow::Result;
use walrus::ir::{Const, GlobalSet, Instr, Value};
use walrus::{ConstExpr, FunctionKind, Module, ValType};

use crate::numbers::Numbers;

/// `called NUMBER` is exported for each function that the module itself contains: 1 once it was
/// called.
pub(crate) fn counting(module: &[u8]) -> Result<Vec<u8>> {
    let mut module = Module::from_buffer(module)?;
    let numbers = Numbers::of(&module);
    for number in 0..numbers.len() {
        let id = numbers.id(number);
        let none = ConstExpr::Value(Value::I32(0));
        let FunctionKind::Local(function) = &mut module.funcs.get_mut(id).kind else {
            continue;
        };
        let global = module.globals.add_local(ValType::I32, true, false, none);
        module.exports.add(&format!("called {number}"), global);
        let entry = function.entry_block();
        let mark = [
            Instr::Const(Const {
                value: Value::I32(1),
            }),
            Instr::GlobalSet(GlobalSet { global }),
        ];
        let instrs = &mut function.block_mut(entry).instrs;
        instrs.splice(0..0, mark.map(|instr| (instr, Default::default())));
    }
    Ok(module.emit_wasm())
}

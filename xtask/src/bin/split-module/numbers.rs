//! Functions by number: their index in the module, which is the same each time that it is read.

use std::collections::{BTreeSet, HashMap};

use walrus::ir::{self, Visitor};
use walrus::{ConstExpr, ElementItems, FunctionId, FunctionKind, LocalFunction, Module};

/// The functions of a module in their order, imported ones first.
pub(crate) struct Numbers {
    ids: Vec<FunctionId>,
    numbers: HashMap<FunctionId, usize>,
}

impl Numbers {
    pub(crate) fn of(module: &Module) -> Self {
        let ids: Vec<FunctionId> = module.funcs.iter().map(walrus::Function::id).collect();
        let numbers = ids.iter().enumerate().map(|(at, &id)| (id, at)).collect();
        Self { ids, numbers }
    }

    pub(crate) fn id(&self, number: usize) -> FunctionId {
        self.ids[number]
    }

    pub(crate) fn number(&self, id: FunctionId) -> usize {
        self.numbers[&id]
    }

    pub(crate) fn len(&self) -> usize {
        self.ids.len()
    }

    /// The functions that a function's body calls or takes the address of; none for an imported
    /// one.
    pub(crate) fn callees(&self, module: &Module, number: usize) -> BTreeSet<usize> {
        struct Seen<'a>(&'a Numbers, BTreeSet<usize>);
        impl<'a> Visitor<'a> for Seen<'_> {
            fn visit_function_id(&mut self, id: &FunctionId) {
                self.1.insert(self.0.number(*id));
            }
        }
        let mut seen = Seen(self, BTreeSet::new());
        if let Some(local) = local(module, self.id(number)) {
            ir::dfs_in_order(&mut seen, local, local.entry_block());
        }
        seen.1
    }
}

/// A function that the module itself contains.
pub(crate) fn local(module: &Module, id: FunctionId) -> Option<&LocalFunction> {
    match &module.funcs.get(id).kind {
        FunctionKind::Local(local) => Some(local),
        _ => None,
    }
}

/// The functions in the entries of a table segment.
pub(crate) fn functions(items: &ElementItems) -> Vec<Option<FunctionId>> {
    match items {
        ElementItems::Functions(ids) => ids.iter().copied().map(Some).collect(),
        ElementItems::Expressions(_, items) => items
            .iter()
            .map(|item| match item {
                ConstExpr::RefFunc(id) => Some(*id),
                _ => None,
            })
            .collect(),
    }
}

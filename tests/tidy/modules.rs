//! Module graph of a crate: which module uses which, read off `use` declarations and paths that begin with `crate`,
//! `super` or `self`.
//!
//! Code under `#[cfg(test)]` and files named `tests.rs` are left out. Names that a parent module imports are followed to
//! the module that defines them, so that a re-export hides nothing.

use std::collections::{BTreeMap, BTreeSet, VecDeque};
use std::fs;
use std::path::Path;

use proc_macro2::{Delimiter, TokenStream, TokenTree};

/// Names from the crate's root to a module, or beyond it to an item.
type Names = Vec<String>;

/// One module as its file tells it.
#[derive(Debug, Default)]
struct Module {
    /// Paths that the module uses, from the crate's root.
    used: Vec<Names>,
    /// Imported names and what they stand for.
    imports: BTreeMap<String, Names>,
    /// Modules all of whose names are imported.
    globs: Vec<Names>,
}

/// Modules of a crate by their names.
#[derive(Debug, Default)]
pub(crate) struct Modules {
    modules: BTreeMap<Names, Module>,
    /// Modules that exist in tests only.
    for_tests: BTreeSet<Names>,
}

impl Modules {
    /// Reads the source folder of a crate, without its binaries below `bin`.
    pub(crate) fn read(folder: &Path) -> Self {
        let mut sources = Vec::new();
        collect(folder, &mut Vec::new(), &mut sources);
        Self::parse(sources.iter().map(|(names, text)| (names.clone(), text.as_str())))
    }

    /// Takes modules from their names and texts.
    pub(crate) fn parse<'a>(sources: impl IntoIterator<Item = (Names, &'a str)>) -> Self {
        let sources: Vec<(Names, TokenStream)> = sources
            .into_iter()
            .map(|(names, text)| {
                let tokens = text.parse().unwrap_or_else(|fault| panic!("{}: {fault}", names.join("::")));
                (names, tokens)
            })
            .collect();
        let mut found = Self::default();
        for (names, _) in &sources {
            found.modules.insert(names.clone(), Module::default());
        }
        for (names, tokens) in sources {
            found.walk(&names, tokens);
        }
        let for_tests = found.for_tests.clone();
        found
            .modules
            .retain(|names, _| !(1..=names.len()).any(|length| for_tests.contains(&names[..length])));
        found
    }

    /// Reads the tokens of a module, or of any group within it.
    fn walk(&mut self, here: &Names, tokens: TokenStream) {
        let tokens: Vec<TokenTree> = tokens.into_iter().collect();
        let mut at = 0;
        while at < tokens.len() {
            let word = word(tokens.get(at));
            if is_test_attribute(&tokens[at..]) {
                at = self.skip_item(here, &tokens, at);
            } else if word == "mod"
                && let Some(TokenTree::Group(body)) = tokens.get(at + 2)
                && body.delimiter() == Delimiter::Brace
            {
                let inner = [here.as_slice(), &[self::word(tokens.get(at + 1))]].concat();
                self.modules.entry(inner.clone()).or_default();
                self.walk(&inner, body.stream());
                at += 3;
            } else if word == "use"
                && !matches!(tokens.get(at + 1), Some(TokenTree::Punct(mark)) if mark.as_char() == '<')
            {
                let end = tokens[at..].iter().position(is_semicolon).map_or(tokens.len(), |end| at + end);
                self.import(here, &Vec::new(), &tokens[at + 1..end]);
                at = end;
            } else if ["crate", "super", "self"].contains(&word.as_str()) && is_path(&tokens[at + 1..]) {
                let (path, length) = path(&tokens[at..]);
                let path = self.absolute(here, &path);
                self.modules.entry(here.clone()).or_default().used.extend(path);
                at += length;
            } else {
                if let TokenTree::Group(group) = &tokens[at] {
                    self.walk(here, group.stream());
                }
                at += 1;
            }
        }
    }

    /// Returns the place after an item that exists in tests only, and remembers its name if it is a module.
    fn skip_item(&mut self, here: &Names, tokens: &[TokenTree], start: usize) -> usize {
        let is_end = |token: &TokenTree| {
            is_semicolon(token)
                || matches!(token, TokenTree::Group(group) if group.delimiter() == Delimiter::Brace)
        };
        let length = tokens[start..].iter().position(is_end).map_or(tokens.len() - start, |end| end + 1);
        let item = &tokens[start..start + length];
        if let Some(place) = item.iter().position(|token| word(Some(token)) == "mod") {
            self.for_tests.insert([here.as_slice(), &[word(item.get(place + 1))]].concat());
        }
        start + length
    }

    /// Takes the names of a `use` declaration, or of a part of it in braces.
    fn import(&mut self, here: &Names, prefix: &Names, tokens: &[TokenTree]) {
        for part in tokens.split(|token| matches!(token, TokenTree::Punct(mark) if mark.as_char() == ',')) {
            let (own, length) = path(part);
            let names = [prefix.as_slice(), &own].concat();
            match part.get(length) {
                Some(TokenTree::Group(group)) => {
                    let inner: Vec<TokenTree> = group.stream().into_iter().collect();
                    self.import(here, &names, &inner);
                }
                rest => self.take(here, names, rest, part.get(length + 1)),
            }
        }
    }

    /// Takes one imported name, with what follows it: `as NAME`, `*` or nothing.
    fn take(&mut self, here: &Names, mut names: Names, rest: Option<&TokenTree>, next: Option<&TokenTree>) {
        if names.len() > 1 && names.last().is_some_and(|last| last == "self") {
            names.pop();
        }
        let Some(target) = self.absolute(here, &names) else { return };
        let module = self.modules.entry(here.clone()).or_default();
        module.used.push(target.clone());
        if matches!(rest, Some(TokenTree::Punct(mark)) if mark.as_char() == '*') {
            module.globs.push(target);
            return;
        }
        let name = if word(rest) == "as" { word(next) } else { names.last().cloned().unwrap_or_default() };
        module.imports.insert(name, target);
    }

    /// Returns a path from the crate's root; `None` for one that leads out of the crate.
    fn absolute(&self, here: &Names, path: &Names) -> Option<Names> {
        let mut base = here.clone();
        let mut rest = path.as_slice();
        match path.first()?.as_str() {
            "crate" => (base, rest) = (Vec::new(), &path[1..]),
            "self" => rest = &path[1..],
            "super" => {}
            first => {
                let child = [here.as_slice(), &[first.to_owned()]].concat();
                return self.modules.contains_key(&child).then(|| [here.as_slice(), path].concat());
            }
        }
        while rest.first().is_some_and(|first| first == "super") {
            base.pop()?;
            rest = &rest[1..];
        }
        Some([&base, rest].concat())
    }

    /// Returns the module that defines what a path leads to.
    fn module_of(&self, path: &Names, depth: usize) -> Names {
        let mut here = Vec::new();
        for (place, name) in path.iter().enumerate() {
            let child = [here.as_slice(), std::slice::from_ref(name)].concat();
            if self.modules.contains_key(&child) {
                here = child;
                continue;
            }
            // Imports that lead to themselves end somewhere.
            let Some(module) = self.modules.get(&here).filter(|_| depth < 16) else { break };
            let rest = &path[place + 1..];
            let globs =
                module.globs.iter().map(|glob| [glob.as_slice(), std::slice::from_ref(name)].concat());
            let known = module.imports.get(name).cloned();
            let known = known.or_else(|| globs.into_iter().find(|path| self.defines(path)));
            return match known {
                Some(target) => self.module_of(&[target.as_slice(), rest].concat(), depth + 1),
                None => here,
            };
        }
        here
    }

    /// Returns whether a path leads to a module or to an imported name.
    fn defines(&self, path: &Names) -> bool {
        let Some((name, module)) = path.split_last() else { return false };
        let known = |module: &Module| module.imports.contains_key(name);
        self.modules.contains_key(path) || self.modules.get(module).is_some_and(known)
    }

    /// Returns which module uses which, between modules of one folder: the crate's root is the folder of no names.
    fn edges(&self) -> BTreeMap<Names, BTreeMap<String, BTreeSet<String>>> {
        let mut edges: BTreeMap<Names, BTreeMap<String, BTreeSet<String>>> = BTreeMap::new();
        for (from, module) in &self.modules {
            for to in module.used.iter().map(|path| self.module_of(path, 0)) {
                let common = from.iter().zip(&to).take_while(|(a, b)| a == b).count();
                // A module and those inside it are no siblings.
                if let (Some(user), Some(used)) = (from.get(common), to.get(common)) {
                    let folder = edges.entry(from[..common].to_vec()).or_default();
                    folder.entry(user.clone()).or_default().insert(used.clone());
                }
            }
        }
        edges
    }

    /// Returns the shortest circle through each module that lies on one, such as `a → b → a`, with the folder before it.
    pub(crate) fn circles(&self) -> Vec<String> {
        let mut found = Vec::new();
        for (folder, uses) in self.edges() {
            let mut told: BTreeSet<String> = BTreeSet::new();
            for start in uses.keys() {
                if let Some(circle) = circle(&uses, start).filter(|_| !told.contains(start)) {
                    let folder = if folder.is_empty() { String::new() } else { folder.join("::") + ": " };
                    found.push(folder + &circle.join(" → "));
                    told.extend(circle);
                }
            }
        }
        found
    }
}

/// Returns the shortest way from a module back to itself.
fn circle(uses: &BTreeMap<String, BTreeSet<String>>, start: &str) -> Option<Names> {
    let mut waiting = VecDeque::from([vec![start.to_owned()]]);
    let mut seen = BTreeSet::new();
    while let Some(way) = waiting.pop_front() {
        for next in way.last().and_then(|last| uses.get(last)).into_iter().flatten() {
            let longer = [way.as_slice(), std::slice::from_ref(next)].concat();
            if next == start {
                return Some(longer);
            }
            if seen.insert(next.clone()) {
                waiting.push_back(longer);
            }
        }
    }
    None
}

/// Reads the files of a folder of modules.
fn collect(folder: &Path, names: &mut Names, sources: &mut Vec<(Names, String)>) {
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        let stem = path.file_stem().unwrap().to_string_lossy().into_owned();
        if stem == "tests" || path.is_dir() && names.is_empty() && stem == "bin" {
            continue;
        }
        let is_folder_s = ["lib", "main", "mod"].contains(&stem.as_str());
        names.push(stem);
        if path.is_dir() {
            collect(&path, names, sources);
        } else if path.extension().is_some_and(|ending| ending == "rs") {
            let module = if is_folder_s { &names[..names.len() - 1] } else { names.as_slice() };
            sources.push((module.to_vec(), fs::read_to_string(&path).unwrap()));
        }
        names.pop();
    }
}

/// Returns an identifier, or nothing where another token stands.
fn word(token: Option<&TokenTree>) -> String {
    if let Some(TokenTree::Ident(word)) = token { word.to_string() } else { String::new() }
}

fn is_semicolon(token: &TokenTree) -> bool {
    matches!(token, TokenTree::Punct(mark) if mark.as_char() == ';')
}

/// Returns whether `::` comes first.
fn is_path(tokens: &[TokenTree]) -> bool {
    let colon = |token: &TokenTree| matches!(token, TokenTree::Punct(mark) if mark.as_char() == ':');
    tokens.len() > 1 && tokens[..2].iter().all(colon)
}

/// Returns the names of a path, and how many tokens they take with the `::` after them if a group or `*` follows.
fn path(tokens: &[TokenTree]) -> (Names, usize) {
    let (mut names, mut at) = (Vec::new(), 0);
    if is_path(tokens) {
        at = 2;
    }
    while let Some(TokenTree::Ident(name)) = tokens.get(at) {
        names.push(name.to_string());
        at += 1;
        if !is_path(&tokens[at..]) {
            break;
        }
        at += 2;
    }
    (names, at)
}

/// Returns whether an attribute comes first that leaves an item to tests.
fn is_test_attribute(tokens: &[TokenTree]) -> bool {
    let [TokenTree::Punct(mark), TokenTree::Group(attribute), ..] = tokens else { return false };
    let text = attribute.stream().to_string();
    let words: Vec<&str> = text.split(|c: char| !c.is_alphanumeric()).collect();
    mark.as_char() == '#' && words[0] == "cfg" && words.contains(&"test") && !words.contains(&"not")
}

// How the search finds and orders pages. Sphinx's own search finds only pages that have every word of a question. This
// one takes pages that have much of it, and a rare word counts more than a common one. Then the page comes first whose
// title, name and description in the index say most of what was asked. DESCRIPTIONS is written above by the build.
const MUCH = 0.3; // of the weight that the page with most of the question has

function stemsOf(text) {
  const words = text.toLowerCase().match(/[a-z0-9]+(?:_[a-z0-9]+)*/g) || [];
  const parts = words.flatMap((word) => (word.includes("_") ? [word, ...word.split("_")] : [word]));
  const stemmer = new Stemmer();
  return new Set(parts.filter((word) => !stopwords.has(word)).map((word) => stemmer.stemWord(word)));
}

function askedStems() {
  return [...stemsOf(new URLSearchParams(window.location.search).get("q") || "")];
}

// The weight of a word: the logarithm of how few pages have it.
function weightOf(stem) {
  const pages = new Set([Search._index.terms[stem], Search._index.titleterms[stem]].flat());
  pages.delete(undefined);
  return Math.log(1 + Search._index.docnames.length / Math.max(pages.size, 1));
}

function sumOf(stems) {
  return stems.reduce((sum, stem) => sum + weightOf(stem), 0);
}

// The share of what was asked that a text says, by weight.
function shareSaid(asked, text) {
  const there = stemsOf(text);
  return sumOf(asked.filter((stem) => there.has(stem))) / (sumOf(asked) || 1);
}

// The share of a title's words that were asked for.
function shareWanted(asked, title) {
  const there = [...stemsOf(title)];
  return there.filter((stem) => asked.includes(stem)).length / Math.max(there.length, 1);
}

// Sphinx's search for each word alone; a page's score is the share of the question's weight that it has, of 20.
function searchLeniently(strictly) {
  return (searchTerms, excludedTerms) => {
    const asked = [...searchTerms];
    const pages = new Map();
    for (const stem of asked) {
      for (const result of strictly(new Set([stem]), excludedTerms)) {
        const page = pages.get(result[0]) || { result: result, had: 0 };
        page.had += weightOf(stem);
        pages.set(result[0], page);
      }
    }
    const all = sumOf(asked) || 1, most = Math.max(0, ...[...pages.values()].map((page) => page.had));
    return [...pages.values()]
      .filter((page) => page.had >= MUCH * most)
      .map((page) => page.result.with(4, (20 * page.had) / all));
  };
}

// Sphinx's script, which makes Search, comes before this one, and its index after it.
Search.performTermsSearch = searchLeniently(Search.performTermsSearch);

var Scorer = {
  score: function (result) {
    const docname = result[0], title = result[1], asked = askedStems();
    let score = Math.min(result[4], 20);
    if (asked.length) {
      score += 60 * shareSaid(asked, title) * (0.5 + 0.5 * shareWanted(asked, title));
      score += 40 * shareSaid(asked, title + " " + docname + " " + (DESCRIPTIONS[docname] || ""));
    }
    if (/^(api|commands)\//.test(docname)) score -= 30;
    if (/^(adr|sources)\//.test(docname) || /^(changelog|readme|index)$/.test(docname)) score -= 60;
    return Math.round(score);
  },
  objNameMatch: 11,
  objPartialMatch: 6,
  objPrio: { 0: 15, 1: 5, 2: -5 },
  objPrioDefault: 0,
  title: 15,
  partialTitle: 7,
  term: 5,
  partialTerm: 2,
};

// How much each hit counts. Sphinx finds the pages that have every word; this puts the page first whose title, name
// and description in the index say most of what was asked. DESCRIPTIONS is written above by the build.
function wordsOf(text) {
  var found = text.toLowerCase().match(/[a-z0-9]+/g) || [];
  return Array.from(new Set(found.filter(function (word) { return !stopwords.has(word); })));
}

function alike(a, b) {
  return a === b || (Math.min(a.length, b.length) > 3 && (a.startsWith(b) || b.startsWith(a)));
}

function shareOf(asked, text) {
  var there = wordsOf(text);
  var hits = asked.filter(function (word) { return there.some(function (other) { return alike(word, other); }); });
  return { asked: hits.length / asked.length, text: hits.length / Math.max(there.length, 1) };
}

var Scorer = {
  score: function (result) {
    var docname = result[0], title = result[1], score = Math.min(result[4], 20);
    var asked = wordsOf(new URLSearchParams(window.location.search).get("q") || "");
    if (asked.length) {
      var titled = shareOf(asked, title);
      score += 60 * titled.asked * (0.5 + 0.5 * titled.text);
      score += 40 * shareOf(asked, title + " " + docname + " " + (DESCRIPTIONS[docname] || "")).asked;
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

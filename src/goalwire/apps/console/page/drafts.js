// Keeps what is typed into the page's form and not sent: in this tab if the page is loaded anew, and at the
// console after a lost connection, where what was typed last may not have arrived. It reads what the fields
// show, not what the console knows.
(() => {
  const KEPT = "goalwire-draft"; // where the tab keeps it; `kept.py` asks for it
  const MOST_CHARACTERS = 100_000;
  let awaits_form = sessionStorage.getItem(KEPT) !== null; // until the user has turned to something else

  function shown(field) { // the text in an input, beside the choice of a list, or of a switch
    return field?.value ?? field?.getAttribute("aria-checked") ?? field?.querySelector("input")?.value ?? "";
  }

  function collect() {
    const form = document.querySelector(".q-dialog [data-draft]") ?? document.querySelector(".gw-main [data-draft]");
    if (!form) return null;
    const fields = {};
    for (const each of form.querySelectorAll("[data-field], [data-parameter]"))
      if (each.dataset.was !== shown(each)) fields[each.dataset.field ?? each.dataset.parameter] = shown(each);
    const removable = [...form.querySelectorAll("[data-remove]")].map((each) => each.dataset.remove);
    const lists = {};
    for (const { dataset } of form.querySelectorAll("[data-add]"))
      lists[dataset.add] = removable.filter((path) =>
        path.startsWith(dataset.add) && /^\[\d+\]$/.test(path.slice(dataset.add.length))).length;
    const beside = (name) => shown(document.querySelector(`.gw-main [data-${name}]`));
    return {
      view: form.dataset.draft,
      name: form.dataset.name,
      fields,
      lists,
      yaml: form.querySelector("[data-yaml]")?.value ?? null,
      deadline: beside("deadline"),
      attempts: beside("attempts"),
    };
  }

  function keep() {
    const draft = collect();
    const text = draft && JSON.stringify(draft);
    if (text && text.length <= MOST_CHARACTERS) sessionStorage.setItem(KEPT, text);
    else if (draft || !awaits_form) sessionStorage.removeItem(KEPT);
  }

  function turn(event) {
    if (event.target.closest?.("[data-view], tr[data-key]")) awaits_form = false;
  }

  addEventListener("pagehide", keep);
  addEventListener("click", turn, true);
  window.goalwireDraft = {
    tell() { // after a lost connection
      const draft = collect();
      if (draft) emitEvent("goalwire-draft", JSON.stringify(draft));
    },
  };
})();

// Shows the frame before or after the one that a moving picture shows, which its slider knows, and so ends what plays.
function step(div, by) {
  const slider = div.layout.sliders[0], count = slider.steps.length;
  return Plotly.animate(div, ...slider.steps[((slider.active || 0) + by + count) % count].args);
}

// Buttons that do so, for the mouse and for the keyboard.
function stepper(div) {
  const group = Object.assign(document.createElement("div"), { className: "steps" });
  for (const [by, words, name] of [[-1, "◀ step", "one frame back"], [1, "step ▶", "one frame forward"]]) {
    const button = Object.assign(document.createElement("button"), { type: "button", textContent: words, title: name });
    button.setAttribute("aria-label", name);
    button.addEventListener("click", () => step(div, by));
    group.append(button, " ");
  }
  return group;
}

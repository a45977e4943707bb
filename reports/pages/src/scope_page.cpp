#include "evenstep/pages/scope_page.h"

#include <fmt/format.h>

namespace evenstep {
namespace {

Html choice(const std::string& id, const std::string& label, const std::vector<std::string>& options) {
  Html list;
  for (std::size_t i = 0; i < options.size(); ++i) list += element("option", {{"value", std::to_string(i)}}, options[i]);
  return element("label", {{"class", "choice"}}, Html(label) + element("select", {{"id", id}}, list));
}

/// A chart that the script draws, with a line of explanation.
Html chart(const std::string& name, const std::string& title, const std::string& meaning) {
  const Html plot = element("div", {{"class", "plot"}, {"data-live", name}}, Html());
  return element("h3", title) + element("figure", {{"class", "chart"}}, plot + element("figcaption", meaning));
}

PageSection now_section() {
  const Html figures = element("dl", {{"id", "figures"}}, Html());
  const Html note = element("p", {{"class", "note"}},
                            "Figures of the last second; in brackets those of the whole run so far. A state is the worst of "
                            "the last tenth of a second.");
  return {"now", "Now", element("dl", {{"id", "states"}, {"aria-live", "polite"}}, Html()) + figures + note};
}

PageSection hand_section(const ScopeText& text) {
  const std::string& live = text.strategy;
  Html body = element("div", {{"class", "controls row"}},
                      choice("device", "Device", text.devices) + choice("axis", "Axis", {"x", "y", "z"}) +
                          element("button", {{"type", "button"}, {"id", "hold"}, {"aria-pressed", "false"}}, "Hold"));
  body +=
      chart("hand", "The hand as the physics sees it",
            fmt::format("Where the hand is for each step, over simulation time: {}, and what direct would read, the newest "
                        "sample.",
                        live));
  body +=
      chart("speed", "Its speed from step to step", "The same, as change per step size. An even hand gives an even line.");
  body += chart("force", "The force at the device's ticks",
                fmt::format("Over real time: what was sent{}",
                            text.shadow_note.empty() ? ", and what direct would have sent for the same hand." : "."));
  if (!text.shadow_note.empty()) body += element("p", {{"class", "note"}}, text.shadow_note);
  return {"hand", "Hand and force", body};
}

PageSection margin_section() {
  return {"margins", "Margins of the buffers",
          chart("margins", "Time to spare",
                "Per step: until its force is due, and from the time that it reads to the newest sample. Below 0 it was "
                "late. A strategy without a map (direct) has none.")};
}

}  // namespace

Page scope_page(const ScopeText& text) {
  Page page;
  page.live = true;
  page.title = text.scenario;
  page.kind = "live run";
  page.summary = element("p", {{"id", "connection"}, {"role", "status"}}, "Connecting …");
  page.summary +=
      element("p", {{"class", "note"}},
              "Ctrl-C in its terminal ends the run. evenstep is not a safety device. What this page does not come "
              "for in time is dropped and counted; the loop never waits for it.");
  page.sections = {now_section(), hand_section(text), margin_section()};
  page.charts = text.program;
  return page;
}

}  // namespace evenstep

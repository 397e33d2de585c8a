#include "app/live.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <memory>
#include <numbers>

#include "app/advice.hpp"
#include "app/player.hpp"
#include "instruments/draw/plot.hpp"
#include "instruments/draw/window.hpp"
#include "instruments/measure/clock.hpp"
#include "instruments/pictures/pictures.hpp"

namespace app {
namespace {

using draw::Rect;
using draw::Window;

constexpr double page_width = 960, page_height = 600, plots_height = 220, panel_width = 340;

double wall_seconds() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

/// A line for the reader's notes, and for scripts.
void say(const std::string& line) {
  fmt::print("{}\n", line);
  std::fflush(stdout);
}

std::string name_of(const Parameter& parameter) { return parameter.option.substr(2); }

/// In the window options are controls.
std::string of_controls(std::string text) {
  for (std::size_t at = 0; (at = text.find("--", at)) != std::string::npos;) text.erase(at, 2);
  return text;
}

std::string with_unit(double value, const std::string& unit) {
  return unit.empty() ? fmt::format("{:.4g}", value) : fmt::format("{:.4g} {}", value, unit);
}

/// What a slider should reach around a default: a few times as much, or all that is allowed.
Window::Span span_of(const Parameter& parameter) {
  const double start = std::abs(parameter.value());
  const auto [low, high] = parameter.allowed;
  const bool only_whole = parameter.is_whole();
  const bool angle = parameter.unit == "rad";
  if (high - low <= 200.0 && !angle) return {low, high, false, only_whole};
  if (low > 0.0) {
    const double middle = std::max(start, low);
    return {std::max(low, middle / 100.0), std::min(high, middle * 100.0), true, only_whole};
  }
  const double usual = parameter.unit == "m" ? 1.0 : 10.0;
  const double most = std::min(high, angle         ? std::max(std::numbers::pi, start)
                                     : start > 0.0 ? 3.0 * start
                                                   : usual);
  return {std::max(low, -most), most, false, only_whole};
}

Window::Span span_of_step(double step) { return {step / 100.0, 20.0 * step, true}; }

/// Where the controls stand in the panel: rows of a name at the left and what is moved beside it.
class Layout {
 public:
  struct Control {
    std::string name;
    Rect place;
  };

  Layout(const Chapter& chapter) {
    row({"run", "single_step", "reset"}, true);
    words_ = {margin, top_, panel_width - 2 * margin,
              5.0 * draw::Pen::line_height(draw::Font::small)};
    top_ = words_.bottom() + 6.0;
    row("speed");
    group();
    for (const Parameter& parameter : chapter.parameters) {
      if (parameter.is(switchable)) row({name_of(parameter) + "_on"}, false);
      if (parameter.is_switch())
        row({name_of(parameter)}, false);
      else
        row(name_of(parameter));
    }
    group();
    for (const char* name : {"step", "integrator"}) row(name);
    if (chapter.has_constraints)
      for (const char* name : {"stabilization", "ks", "kd"}) row(name);
    group();
    row({"forces", "trail", "names"}, false);
  }

  const Rect& operator[](const std::string& name) const {
    return std::find_if(controls_.begin(), controls_.end(),
                        [&](const Control& control) { return control.name == name; })
        ->place;
  }
  const std::vector<Control>& controls() const { return controls_; }
  /// For what there is to tell.
  const Rect& words() const { return words_; }
  /// The place of a control's name.
  static Rect beside(const Rect& place) {
    return {margin, place.top + 3.0, first - margin, place.height};
  }

 private:
  static constexpr double margin = 12, first = 118, height = 21, spacing = 27;

  void group() { top_ += 9.0; }
  void row(const std::string& name) {
    controls_.push_back({name, {first, top_, panel_width - first - margin, height}});
    top_ += spacing;
  }
  /// Buttons, or the squares of check boxes; one alone stands among the sliders.
  void row(const std::vector<std::string>& names, bool buttons) {
    const double width = (panel_width - 2 * margin) / 3.0;
    double left = names.size() == 1 ? first : margin;
    for (const std::string& name : names) {
      controls_.push_back({name, {left, top_, buttons ? width - 6.0 : height, height}});
      left += width;
    }
    top_ += spacing;
  }

  std::vector<Control> controls_;
  Rect words_;
  double top_ = margin;
};

constexpr double narrow = 560.0;  // as on a phone

/// The part of a window's height that is the scene's; below it are the plots.
double scene_share(double width) {
  return width < narrow ? 0.55 : page_height / (page_height + plots_height);
}

/// For two plots: beside each other, or one below the other where that is too narrow.
std::array<Rect, 2> halves(const Rect& area) {
  constexpr double gap = 24.0;
  if (area.width < narrow) {
    const double half = 0.5 * area.height;
    return {Rect{area.left, area.top, area.width, half},
            Rect{area.left, area.top + half, area.width, half}};
  }
  const double half = 0.5 * (area.width - gap);
  return {Rect{area.left, area.top, half, area.height},
          Rect{area.left + half + gap, area.top, half, area.height}};
}

std::unique_ptr<Window> open_window(const std::string& title) {
  try {
    return std::make_unique<Window>(title, static_cast<int>(page_width + panel_width),
                                    static_cast<int>(page_height + plots_height), panel_width,
                                    draw::theme("light"));
  } catch (const std::runtime_error& error) {
    throw std::runtime_error(
        fmt::format("live: {}; `snapshot` draws pictures without one", error.what()));
  }
}

class Live {
 public:
  Live(const Chapter& chapter, const measure::RunOptions& run, bool step_given)
      : chapter_(chapter),
        run_(run),
        kept_run_(run),
        step_given_(step_given),
        step_span_(span_of_step(run.step)),
        stage_(chapter.stage(run)),
        window_(open_window(chapter.title)),
        layout_(chapter) {
    for (const Parameter& parameter : chapter.parameters) {
      spans_.push_back(span_of(parameter));
      kept_.push_back(parameter.value());
    }
    last_ = kept_;
    message_ = fault_of_gains(run).value_or("");
    if (run.method.stabilization != mechanics::Stabilization::feedback) return;
    ks_ = run.method.ks;
    kd_ = run.method.kd;
  }

  void print_controls() const {
    for (const auto& [name, place] : layout_.controls())
      say(fmt::format("{} {:.0f} {:.0f}", name, page_width + place.center().x, place.center().y));
  }

  void loop() {
    window_->run([this](double wall) {
      frame(wall);
      all_ += wall;
      ++frames_;
      work_ += window_->frame_seconds();
    });
    sum_up();
  }

 private:
  void frame(double wall) {
    for (int i = window_->presses(Window::Key::space); i > 0; --i) run_or_pause();
    for (int i = window_->presses(Window::Key::right) + window_->presses(Window::Key::s); i > 0;
         --i)
      single_step();
    if (window_->presses(Window::Key::r) > 0) reset();
    hand();
    if (playing_) play(wall);
    draw_pages();
    controls();
  }

  std::string now() const { return fmt::format("at t = {:.6g} s", stage_->time()); }

  // --------------------------------------------------------------------------------------------
  // time

  void run_or_pause() {
    if (diverged_) return;
    playing_ = !playing_;
    player_.rest();
    say((playing_ ? "runs " : "paused ") + now());
  }

  void single_step() {
    if (diverged_) return;
    if (playing_) run_or_pause();
    advance(1);
    if (!diverged_) say("step " + now());
  }

  void reset() {
    make_stage(false);
    say("reset " + now());
  }

  void play(double wall) {
    const double start = stage_->time();
    player_.play(
        wall, speed_, run_.step, [this](long steps) { advance(steps); }, wall_seconds);
    played_ += wall;
    simulated_ += stage_->time() - start;
  }

  /// A run that cannot go on stands still and says why.
  void advance(long steps) {
    if (diverged_) return;
    const double start = measure::cpu_seconds();
    try {
      stage_->advance(steps);
      steps_ += steps;
    } catch (const mechanics::Diverged& diverged) {
      diverged_ = true;
      playing_ = false;
      message_ = of_controls(
          fmt::format("stopped {}; {}", diverged.what(), advice(chapter_, run_, diverged.trouble)));
      say(message_);
    }
    stepping_ += measure::cpu_seconds() - start;
  }

  // --------------------------------------------------------------------------------------------
  // changes

  /// The scene as the controls have it now: from where it is, or from its start. One that cannot be
  /// made leaves all as it was.
  void make_stage(bool go_on) {
    stage_->release();
    const bool feedback = run_.method.stabilization == mechanics::Stabilization::feedback;
    run_.method.ks = feedback ? ks_ : 0.0;
    run_.method.kd = feedback ? kd_ : 0.0;
    if (!step_given_) {
      run_.step = default_step(chapter_, run_.duration);
      step_span_ = span_of_step(run_.step);
    }
    std::string message;
    try {
      auto stage = chapter_.stage(run_);
      if (go_on && !diverged_ && stage_->time() > 0.0) stage->take_over(*stage_);
      stage_ = std::move(stage);
      message = fault_of_gains(run_).value_or("");
      diverged_ = false;
      kept_run_ = run_;
      for (std::size_t i = 0; i < kept_.size(); ++i) kept_[i] = chapter_.parameters[i].value();
    } catch (const std::exception& error) {
      message = of_controls(error.what());
      run_ = kept_run_;
      for (std::size_t i = 0; i < kept_.size(); ++i) chapter_.parameters[i].set(kept_[i]);
    }
    if (!message.empty() && message != message_) say(message);
    message_ = message;
    player_.rest();
  }

  void hand() {
    const Window::Mouse mouse = window_->mouse();
    if (mouse.pressed && !diverged_ && stage_->grip(mouse.at)) say("pulled " + now());
    if (!stage_->gripped()) return;
    stage_->pull(mouse.at);
    if (mouse.down) return;
    stage_->release();
    say("let go " + now());
  }

  // --------------------------------------------------------------------------------------------
  // what is seen

  void draw_pages() {
    const double width = window_->pages_width();
    const double height = window_->height() * scene_share(width);
    draw::Pen page = window_->pen(width, height), all = window_->pen(width, window_->height());
    show_.verdict = stage_->settled();
    draw_page(page, *stage_, show_);
    const Rect plots{14.0, height, width - 28.0, window_->height() - height - 8.0};
    const auto [first, second] = halves(plots);
    draw_errors(all, first, "energy error [J]", &pictures::Stage::Errors::energy,
                stage_->gripped() ? "none while the mouse pulls" : "");
    draw_errors(all, second, fmt::format("constraint error |C| [{}]", chapter_.constraint_unit),
                &pictures::Stage::Errors::constraint, "");
  }

  void draw_errors(draw::Pen& pen, const Rect& area, std::string label,
                   double pictures::Stage::Errors::*error, std::string remark) const {
    const auto none = [&](const pictures::Stage::Sample& sample) {
      return std::none_of(
          sample.errors.begin(), sample.errors.end(),
          [&](const pictures::Stage::Errors& errors) { return errors.*error > 0.0; });
    };
    const auto untold = [&](const pictures::Stage::Sample& sample) {
      return std::isnan(sample.errors.front().*error);
    };
    const auto& samples = stage_->samples();
    if (remark.empty() && std::all_of(samples.begin(), samples.end(), untold))
      remark = "not compared, a load takes energy";
    if (remark.empty() && std::all_of(samples.begin(), samples.end(), none)) remark = "none so far";
    if (!remark.empty()) label += ": " + remark;
    const double end = std::max(stage_->time(), run_.duration);
    draw::Plot plot{.x = {.label = "time [s]", .min = end - run_.duration, .max = end},
                    .y = {.label = label, .log = true},
                    .legend = draw::Legend::bottom_right};
    for (std::size_t i = 0; i < stage_->names().size(); ++i) {
      draw::Curve curve{.label = stage_->names()[i],
                        .dash = i == 0 ? draw::Dash::solid : draw::Dash::dashed};
      for (const pictures::Stage::Sample& sample : stage_->samples())
        curve.points.push_back({sample.t, sample.errors[i].*error});
      plot.curves.push_back(std::move(curve));
    }
    draw::draw_plot(pen, area, plot);
  }

  // --------------------------------------------------------------------------------------------
  // the panel

  void controls() {
    if (window_->button(layout_["run"], playing_ ? "pause" : "run", !diverged_)) run_or_pause();
    if (window_->button(layout_["single_step"], "step", !diverged_)) single_step();
    if (window_->button(layout_["reset"], "reset")) reset();
    slider("speed", speed_, {0.01, 10.0, true}, "×", {0.01, 1000.0}, [] {});
    for (std::size_t i = 0; i < chapter_.parameters.size(); ++i) parameter(i);
    slider("step", run_.step, step_span_, "s", positive, [this] {
      step_given_ = true;
      make_stage(true);
    });
    methods();
    toggle("forces", show_.forces);
    toggle("trail", show_.trail);
    toggle("names", show_.names);
    words();
  }

  /// Applies each change of the value, and tells it when it has come to rest.
  template <class Apply>
  void slider(const std::string& name, double& value, const Window::Span& span,
              const std::string& unit, const Range& allowed, Apply&& apply, bool enabled = true) {
    window_->label(Layout::beside(layout_[name]), name);
    const double before = value;
    const bool rests = window_->slider(layout_[name], name, value, span, unit, enabled);
    // What is typed may be anything.
    value = std::isnan(value) ? before : std::clamp(value, allowed.low, allowed.high);
    if (value != before) apply();
    if (rests) say(fmt::format("{} {} {}", name, with_unit(value, unit), now()));
  }

  void parameter(std::size_t i) {
    const Parameter& parameter = chapter_.parameters[i];
    const std::string name = name_of(parameter);
    double value = parameter.value();
    const auto apply = [&] {
      parameter.set(value);
      make_stage(parameter.is(acts));
      value = parameter.value();  // as it was, where that cannot be
    };
    bool on = value != 0.0;
    if (parameter.is_switch()) {
      window_->label(Layout::beside(layout_[name]), name);
      if (!window_->check(layout_[name], "##" + name, on)) return;
      value = on ? 1.0 : 0.0;
      apply();
      say(fmt::format("{} {} {}", name, value, now()));
      return;
    }
    if (parameter.is(switchable) && window_->check(layout_[name + "_on"], name, on)) {
      value = !on ? 0.0 : last_[i] != 0.0 ? last_[i] : 1.0;
      apply();
      say(fmt::format("{} {} {}", name, with_unit(value, parameter.unit), now()));
    }
    slider(name, value, spans_[i], parameter.unit, parameter.allowed, apply);
    if (value != 0.0) last_[i] = value;
  }

  void methods() {
    std::vector<std::string> integrators, stabilizations;
    for (const auto& scheme : integrators::schemes) integrators.emplace_back(scheme.text);
    for (const auto& name : mechanics::stabilization_names) stabilizations.emplace_back(name);
    choice("integrator", integrators, run_.method.integrator);
    if (!chapter_.has_constraints) return;
    choice("stabilization", stabilizations, run_.method.stabilization);
    const bool feedback = run_.method.stabilization == mechanics::Stabilization::feedback;
    const auto apply = [this] { make_stage(true); };
    slider("ks", ks_, {0.1, 1e5, true}, "1/s²", not_negative, apply, feedback);
    slider("kd", kd_, {0.1, 1e3, true}, "1/s", not_negative, apply, feedback);
  }

  template <class Enum>
  void choice(const std::string& name, const std::vector<std::string>& texts, Enum& chosen) {
    window_->label(Layout::beside(layout_[name]), name);
    int index = static_cast<int>(chosen);
    if (!window_->choice(layout_[name], name, texts, index)) return;
    chosen = static_cast<Enum>(index);
    make_stage(true);
    say(fmt::format("{} {} {}", name, texts[static_cast<std::size_t>(index)], now()));
  }

  void toggle(const std::string& name, bool& shown) {
    if (window_->check(layout_[name], name, shown))
      say(fmt::format("{} {} {}", name, shown ? "on" : "off", now()));
  }

  void words() {
    const Rect& place = layout_.words();
    const draw::Theme& theme = window_->theme();
    const bool late = playing_ && player_.kept() < 0.95;
    std::string text = message_;
    if (const auto verdict = stage_->verdict();
        text.empty() && stage_->settled() && !verdict.right())
      text = of_controls(fmt::format("far from right: {}; {}", verdict.text(),
                                     advice(chapter_, run_, verdict.trouble())));
    const bool wrong = message_.empty() && !text.empty();
    if (wrong != wrong_) {
      wrong_ = wrong;
      if (wrong) say(fmt::format("{} {}", text, now()));
    }
    if (text.empty() && late)
      text = fmt::format("cannot keep up: {} × real time",
                         pictures::figure(player_.kept() * speed_, 2));
    if (late != late_) {
      late_ = late;
      if (late) say(fmt::format("{} {}", text, now()));
    }
    if (!text.empty()) return window_->text(place, text, theme.applied_force);
    window_->text(place,
                  std::string("space runs and pauses, → or s takes one step, r goes back to the "
                              "start. Drag a thing with the mouse. ") +
                      Window::usage,
                  theme.muted);
  }

  void sum_up() const {
    const double frames = static_cast<double>(std::max(1L, frames_));
    std::string line =
        fmt::format("{:.1f} s simulated in {:.1f} s: {:.0f} frames a second of {:.1f} ms",
                    simulated_, played_, frames / std::max(all_, 1e-9), 1e3 * work_ / frames);
    if (played_ > 0.0 && steps_ > 0)
      line +=
          fmt::format(", {:.0f} steps a second of {:.2g} µs", static_cast<double>(steps_) / played_,
                      1e6 * stepping_ / static_cast<double>(steps_));
    say(line);
  }

  const Chapter& chapter_;
  measure::RunOptions run_, kept_run_;  ///< as the controls have it, and as the stage was made with
  double ks_ = 100.0, kd_ = 20.0;       ///< for when there is feedback
  std::vector<double> kept_, last_;  ///< the parameters of the stage, and their last values but 0
  std::vector<Window::Span> spans_;
  bool step_given_;  ///< else it follows the parameters
  Window::Span step_span_;
  std::unique_ptr<pictures::Stage> stage_;
  std::unique_ptr<Window> window_;
  Layout layout_;
  Player player_;
  pictures::Show show_;
  double speed_ = 1.0;
  bool playing_ = false, diverged_ = false, late_ = false, wrong_ = false;
  std::string message_;

  long frames_ = 0, steps_ = 0;
  double all_ = 0.0, work_ = 0.0;          ///< of the window, and for its frames [s]
  double played_ = 0.0, simulated_ = 0.0;  ///< while it ran [s]
  double stepping_ = 0.0;                  ///< processor time of the steps [s]
};

void show(const Chapter& chapter, const measure::RunOptions& run, bool step_given, bool controls) {
  Live scene(chapter, run, step_given);
  if (controls) scene.print_controls();
  scene.loop();
}

}  // namespace

decltype(live) live = show;

}  // namespace app

#include "app/snapshot.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "instruments/draw/page.hpp"
#include "instruments/files/files.hpp"
#include "instruments/files/progress.hpp"

namespace app {
namespace {

/// Returns the picture's caption.
std::string write(const std::filesystem::path& path, const draw::Page& page,
                  const std::function<void(draw::Pen&)>& draw, const std::string& remark = {}) {
  std::string caption;
  const draw::Image image = draw::render(page, [&](draw::Pen& pen) {
    pen.set_remark(remark);
    draw(pen);
    caption = pen.caption();
  });
  files::write_file(path, draw::encode_png(image));
  return caption;
}

void print(const std::filesystem::path& path) { fmt::print("{}\n", path.string()); }

constexpr double ahead_part = 0.3;  // of the work

double progress_after(std::size_t done, std::size_t all) {
  return ahead_part + (1.0 - ahead_part) * static_cast<double>(done) / static_cast<double>(all);
}

/// A stage that has run to `end`: its view and its arrows' scale hold for all of the way.
std::unique_ptr<pictures::Stage> run_ahead(double end, const Chapter& chapter,
                                           const measure::RunOptions& run,
                                           files::Progress& progress) {
  std::unique_ptr<pictures::Stage> ahead = chapter.stage(run);
  constexpr int parts = 100;
  for (int i = 1; i <= parts; ++i) {
    progress.show(ahead_part * i / parts, "simulated ahead");
    ahead->advance_to(end * i / parts);
  }
  return ahead;
}

/// A stage to be shown up to `end`, whose trail reaches back to its start.
std::unique_ptr<pictures::Stage> stage_up_to(double end, const Chapter& chapter,
                                             measure::RunOptions run, files::Progress& progress) {
  if (end > 0.0) run.duration = end;
  std::unique_ptr<pictures::Stage> stage = chapter.stage(run);
  stage->show_as(*run_ahead(end, chapter, run, progress));
  return stage;
}

void take_series(const Snapshot& snapshot, const Chapter& chapter, const measure::RunOptions& run,
                 const pictures::Show& show, const std::filesystem::path& out) {
  const auto name = [&,
                     digits = std::max<std::size_t>(4, fmt::formatted_size("{}", snapshot.frames))](
                        long frame) { return fmt::format("frame_{:0{}}.png", frame, digits); };
  {
    files::Progress progress;
    const auto stage = stage_up_to(snapshot.end(run), chapter, run, progress);
    for (long i = 0; i < snapshot.frames; ++i) {
      progress.show(
          progress_after(static_cast<std::size_t>(i), static_cast<std::size_t>(snapshot.frames)),
          name(i + 1));
      stage->advance_to(static_cast<double>(i) * snapshot.interval());
      write(out / name(i + 1), snapshot.page,
            [&](draw::Pen& pen) { draw_page(pen, *stage, show); });
    }
  }
  print(out / name(1));
  if (snapshot.frames > 1) fmt::print("to {}\n", (out / name(snapshot.frames)).string());
}

/// The scene at several times on one page, each over its time.
void draw_sheet(draw::Pen& pen, pictures::Stage& stage, const Snapshot& snapshot,
                const std::vector<double>& times, files::Progress& progress) {
  const std::string caption = fmt::format("Under each picture stands its time ({}, step {:g} s).",
                                          stage.run().method.label(), stage.run().step);
  const draw::Rect all = draw::page(pen, stage.title(), caption);
  const double gap = 8.0, line = draw::Pen::line_height(draw::Font::small);
  const double width = (all.width + gap) / snapshot.sheet_columns;
  const double height = (all.height + gap) / snapshot.sheet_rows;
  for (std::size_t i = 0; i < times.size(); ++i) {
    progress.show(progress_after(i, times.size()), "sheet");
    stage.advance_to(times[i]);
    const auto columns = static_cast<std::size_t>(snapshot.sheet_columns);
    const std::size_t row = i / columns, column = i % columns;
    const draw::Rect cell{all.left + width * static_cast<double>(column),
                          all.top + height * static_cast<double>(row), width - gap, height - gap};
    const draw::Rect scene{cell.left, cell.top, cell.width, cell.height - line};
    const std::array<draw::Point, 4> corners{{{scene.left, scene.top},
                                              {scene.right(), scene.top},
                                              {scene.right(), scene.bottom()},
                                              {scene.left, scene.bottom()}}};
    pen.polygon(corners, draw::transparent, pen.theme().grid, 1.0);
    stage.draw(pen, scene.inset(1.0), {.numbers = false});
    pen.text({cell.center().x, cell.bottom() - line / 2}, fmt::format("{:.3g} s", stage.time()),
             pen.theme().muted, draw::Font::small, draw::Align::center);
  }
}

void take_sheet(const Snapshot& snapshot, const Chapter& chapter, const measure::RunOptions& run,
                const std::string& remark, const std::filesystem::path& out) {
  std::vector<double> times = snapshot.at;
  if (times.empty())
    for (int i = 0; i < snapshot.cells(); ++i)
      times.push_back(run.duration * i / std::max(1, snapshot.cells() - 1));
  {
    files::Progress progress;
    const auto stage = stage_up_to(times.back(), chapter, run, progress);
    write(
        out / "sheet.png", snapshot.page,
        [&](draw::Pen& pen) { draw_sheet(pen, *stage, snapshot, times, progress); }, remark);
  }
  print(out / "sheet.png");
}

}  // namespace

double Snapshot::end(const measure::RunOptions& run) const {
  if (frames > 0) return static_cast<double>(frames - 1) * interval();
  return at.empty() ? run.duration : at.back();
}

void Snapshot::check(const measure::RunOptions& run, double most_steps) const {
  const bool sheet = cells() > 0;
  if (fps && frames == 0)
    throw UsageError(fmt::format("--fps {:g}: allowed only with --frames", *fps));
  if (frames > 0 && sheet)
    throw UsageError(
        fmt::format("--sheet {}x{}: allowed only without --frames", sheet_columns, sheet_rows));
  if (frames > 0 && !at.empty())
    throw UsageError(fmt::format("--at {:g}: allowed only without --frames", at.front()));
  if (sheet && at.size() > static_cast<std::size_t>(cells()))
    throw UsageError(fmt::format("--sheet {}x{}: allowed are {} times at most with --at, not {}",
                                 sheet_columns, sheet_rows, cells(), at.size()));
  constexpr int cell_width = 96, cell_height = 75;  // in which a scene can be made out [points]
  if (sheet && (page.width < sheet_columns * cell_width || page.height < sheet_rows * cell_height))
    throw UsageError(fmt::format(
        "--sheet {}x{}: allowed are at most {}x{} on {}x{} points (--size)", sheet_columns,
        sheet_rows, page.width / cell_width, page.height / cell_height, page.width, page.height));
  const bool own_steps = run.method.tolerance > 0.0;
  if (sheet && at.empty() && !own_steps && run.duration < (cells() - 1.01) * run.step)
    throw UsageError(fmt::format(
        "--sheet {}x{}: allowed are at most {:.0f} pictures, one each step of {:g} s up to {:g} s",
        sheet_columns, sheet_rows, std::floor(run.duration / run.step) + 1.0, run.step,
        run.duration));
  for (const double t : at)
    if (t / run.step > most_steps)
      throw UsageError(fmt::format("--at {:g}: allowed is at most {:g} s with a step of {:g} s", t,
                                   most_steps * run.step, run.step));
  if (frames > 1 && !own_steps && interval() < (1.0 - 1e-9) * run.step)
    throw UsageError(
        fmt::format("--fps {:g}: allowed is at most {:g}, a picture each step of {:g} s",
                    1.0 / interval(), 1.0 / run.step, run.step));
  if (static_cast<double>(frames) * interval() / run.step > most_steps)
    throw UsageError(
        fmt::format("--frames {}: allowed is at most {:g} s of them with a step of {:g} s", frames,
                    most_steps * run.step, run.step));
}

void take(const Snapshot& snapshot, const Chapter& chapter, const measure::RunOptions& run,
          const mechanics::Verdict& verdict, const std::filesystem::path& out) {
  // Of the lesson's pictures some move by methods and steps of their own.
  const std::string remark =
      verdict.right()
          ? ""
          : fmt::format("With these options the run is far from right: {}.", verdict.words());
  pictures::Show show{.verdict = !verdict.right()};
  if (show.verdict)
    show.else_say =
        fmt::format("At {:g} s the run is far from right: {}.", snapshot.end(run), verdict.words());
  if (snapshot.frames > 0) return take_series(snapshot, chapter, run, show, out);
  if (snapshot.cells() > 0) return take_sheet(snapshot, chapter, run, remark, out);
  files::Progress progress;
  std::vector<pictures::Picture> pictures;
  if (snapshot.at.empty()) pictures = chapter.pictures(run);
  std::unique_ptr<pictures::Stage> ahead;
  for (const double t : snapshot.at) {
    measure::RunOptions longer = run;
    longer.duration = std::max(run.duration, snapshot.at.back());
    if (!ahead && snapshot.at.size() > 1)
      ahead = run_ahead(snapshot.at.back(), chapter, longer, progress);
    progress.show(progress_after(pictures.size(), 2 * snapshot.at.size()),
                  fmt::format("simulated to {:g} s", t));
    std::unique_ptr<pictures::Stage> stage = chapter.stage(longer);
    if (ahead) stage->show_as(*ahead);
    pictures.push_back(picture_at(std::move(stage), t, show));
  }
  double done = 0.0;
  for (const pictures::Picture& picture : pictures) {
    progress.show(0.5 + 0.5 * done++ / static_cast<double>(pictures.size()), picture.name);
    const std::filesystem::path path = out / (picture.name + ".png");
    const std::string caption =
        write(path, snapshot.page, picture.draw, snapshot.at.empty() ? remark : "");
    progress.clear();
    print(path);
    fmt::print("  {}\n", caption);
  }
}

}  // namespace app

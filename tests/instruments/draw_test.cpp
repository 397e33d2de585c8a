#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <functional>
#include <limits>
#include <set>
#include <stdexcept>
#include <string>
#include <vector>

#include "catch.hpp"
#include "instruments/draw/canvas.hpp"
#include "instruments/draw/image.hpp"
#include "instruments/draw/offscreen.hpp"
#include "instruments/draw/page.hpp"
#include "instruments/draw/plot.hpp"
#include "instruments/draw/ticks.hpp"
#include "picture_check.hpp"

using namespace draw;
using picture_check::Difference, picture_check::difference, picture_check::read_png;

namespace {

const Page small_page{.width = 320, .height = 200, .scale = 1};

struct Scene {
  double bead_x = 60;
  bool curve = true;
  Color bead = theme("light").body;
};

Image picture(const Scene& scene) {
  return render(small_page, [&](Pen& pen) {
    Canvas canvas(pen, page(pen, "valley", "C = 0"), {-110, -130, 110, 10});
    canvas.axes("m");
    std::vector<Point> points;
    for (double x = -100; x <= 100; x += 5) points.push_back({x, -x * x / 100});
    if (scene.curve) canvas.curve(points, pen.theme().track, 2);
    canvas.bead({scene.bead_x, -scene.bead_x * scene.bead_x / 100}, 5, scene.bead,
                pen.theme().body_edge);
  });
}

Color pixel(const Image& image, int x, int y) {
  const auto i = 4 * static_cast<std::size_t>(y * image.width + x);
  return {image.rgba[i], image.rgba[i + 1], image.rgba[i + 2]};
}

bool same(Color a, Color b) { return a.r == b.r && a.g == b.g && a.b == b.b; }

std::vector<std::string> labels(const std::vector<Tick>& ticks) {
  std::vector<std::string> result;
  for (const Tick& tick : ticks) {
    if (!tick.label.empty()) result.push_back(tick.label);
  }
  return result;
}

std::size_t painted(const Image& image) {
  std::size_t count = 0;
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) {
      if (!same(pixel(image, x, y), theme("light").paper)) ++count;
    }
  }
  return count;
}

double linear(std::uint8_t value) {
  const double v = value / 255.0;
  return v <= 0.04045 ? v / 12.92 : std::pow((v + 0.055) / 1.055, 2.4);
}

double luminance(Color c) {
  return 0.2126 * linear(c.r) + 0.7152 * linear(c.g) + 0.0722 * linear(c.b);
}

// A colour in CIELAB, as the eye sees it whose cones `cones` describes: a row each of red, green
// and blue in linear light. sRGB, D65.
using Matrix = std::array<std::array<double, 3>, 3>;
std::array<double, 3> lab(Color c, const Matrix& cones) {
  const auto times = [](const Matrix& m, const std::array<double, 3>& x) {
    std::array<double, 3> y{};
    for (std::size_t i = 0; i < 3; ++i)
      for (std::size_t k = 0; k < 3; ++k) y[i] += m[i][k] * x[k];
    return y;
  };
  std::array<double, 3> seen = times(cones, {linear(c.r), linear(c.g), linear(c.b)});
  for (double& part : seen) part = std::clamp(part, 0.0, 1.0);
  const Matrix to_xyz{{{0.4124564, 0.3575761, 0.1804375},
                       {0.2126729, 0.7151522, 0.0721750},
                       {0.0193339, 0.1191920, 0.9503041}}};
  const auto [X, Y, Z] = times(to_xyz, seen);
  const auto f = [](double t) { return t > 0.008856 ? std::cbrt(t) : 7.787 * t + 16.0 / 116.0; };
  const double fx = f(X / 0.95047), fy = f(Y), fz = f(Z / 1.08883);
  return {116 * fy - 16, 500 * (fx - fy), 200 * (fy - fz)};
}

double distance(const std::array<double, 3>& a, const std::array<double, 3>& b) {
  return std::hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]);
}

}  // namespace

TEST_CASE("any two colours of curves, and of arrows, are told apart by colour-blind readers") {
  // Machado, Oliveira and Fernandes 2009, severity 1: normal, protanopia, deuteranopia, tritanopia.
  const std::array<Matrix, 4> eyes{{{{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}},
                                    {{{0.152286, 1.052583, -0.204868},
                                      {0.114503, 0.786281, 0.099216},
                                      {-0.003882, -0.048116, 1.051998}}},
                                    {{{0.367322, 0.860646, -0.227968},
                                      {0.280085, 0.672501, 0.047413},
                                      {-0.011820, 0.042940, 0.968881}}},
                                    {{{1.255528, -0.076749, -0.178779},
                                      {-0.078411, 0.930809, 0.147602},
                                      {0.004733, 0.691367, 0.303900}}}}};
  for (const char* name : {"light", "dark"}) {
    const Theme& t = theme(name);
    const std::vector<Color> curves(t.series.begin(), t.series.end()),
        arrows{t.weight, t.constraint_force, t.applied_force, t.velocity, t.warning};
    for (const auto& colors : {curves, arrows})
      for (std::size_t i = 0; i < colors.size(); ++i) {
        const double a = luminance(colors[i]), b = luminance(t.paper);
        CHECK((std::max(a, b) + 0.05) / (std::min(a, b) + 0.05) >= 3.0);  // WCAG: graphics
        for (std::size_t k = 0; k < i; ++k)
          for (const Matrix& eye : eyes) {
            INFO(name << ", colours " << k << " and " << i);
            CHECK(distance(lab(colors[k], eye), lab(colors[i], eye)) >= 25.0);
          }
      }
  }
}

TEST_CASE("a picture survives the way through a PNG file") {
  const Image image = picture({});
  const auto file = std::filesystem::temp_directory_path() / "draw_test_round_trip.png";
  std::ofstream(file, std::ios::binary) << encode_png(image);
  const Image back = read_png(file);
  std::filesystem::remove(file);
  CHECK(back.width == 320);
  CHECK(back.height == 200);
  CHECK(difference(image, back).largest_step <= 12);  // of 128 colours at most
  CHECK(picture_check::decode_png(encode_png(back)).rgba == back.rgba);
}

TEST_CASE("a file keeps 128 colours, first of all those that cover most") {
  Image image{300, 40, {}};
  const auto put = [&](int r, int g, int b) {
    for (const int c : {r, g, b, 255}) image.rgba.push_back(static_cast<std::uint8_t>(c));
  };
  for (int y = 0; y < 40; ++y)  // paper, with a row of 300 shades on it
    for (int x = 0; x < 300; ++x) y == 7 ? put(x % 256, x / 2, 40) : put(250, 251, 252);
  const Image back = picture_check::decode_png(encode_png(image));
  CHECK(same(pixel(back, 5, 0), {250, 251, 252}));
  CHECK(difference(image, back).largest_step <= 2);
  std::set<std::array<std::uint8_t, 3>> colors;
  for (int x = 0; x < 300; ++x) {
    const Color c = pixel(back, x, 7);
    colors.insert({c.r, c.g, c.b});
  }
  CHECK(colors.size() == 127);
}

TEST_CASE("a file that is no PNG is named in the error") {
  CHECK_THROWS_WITH(read_png("/no/such.png"), ContainsSubstring("/no/such.png"));
  CHECK_THROWS_WITH(read_png(__FILE__), ContainsSubstring("draw_test.cpp"));
  CHECK_THROWS_AS(encode_png({}), std::runtime_error);
}

TEST_CASE("the same page gives the same bytes, whatever was drawn between") {
  const Image first = picture({});
  render({.width = 100, .height = 50, .scale = 2, .theme = theme("dark")}, [](Pen& pen) {
    pen.text({10, 20}, "Δ", pen.theme().ink);
  });
  CHECK(picture({}).rgba == first.rgba);
}

TEST_CASE("a drawing that fails leaves the next one alone") {
  const Image first = picture({});
  CHECK_THROWS_AS(render(small_page,
                         [](Pen& pen) {
                           pen.clip({0, 0, 1, 1});
                           throw std::runtime_error("no scene");
                         }),
                  std::runtime_error);
  CHECK(picture({}).rgba == first.rgba);
}

TEST_CASE("a page must have sides of 1 to 16384 pixels") {
  const auto nothing = [](Pen&) {};
  CHECK_THROWS_AS(render({.width = 16385, .height = 10, .scale = 1}, nothing),
                  std::invalid_argument);
  CHECK(render({.width = 16384, .height = 10, .scale = 1}, nothing).width == 16384);
  CHECK_THROWS_AS(render({.width = 10, .height = 0}, nothing), std::invalid_argument);
  CHECK_THROWS_AS(render({.scale = std::nan("")}, nothing), std::invalid_argument);
}

TEST_CASE("difference sees what changed") {
  const Image expected = picture({});
  const Difference none = difference(expected, expected);
  CHECK(none.same_size);
  CHECK(none.largest_step == 0);
  CHECK(none.worst_window == 0);

  const Difference moved = difference(expected, picture({.bead_x = 64}));
  CHECK(moved.largest_step > 100);
  CHECK(moved.worst_window > 10);

  const Difference missing = difference(expected, picture({.curve = false}));
  CHECK(missing.largest_step > 100);
  CHECK(missing.worst_window > 10);

  const Difference coloured = difference(expected, picture({.bead = theme("light").weight}));
  CHECK(coloured.largest_step > 50);
  CHECK(coloured.worst_window > 5);
}

TEST_CASE("difference measures steps and windows exactly, and shows where") {
  const Image expected{40, 20, std::vector<std::uint8_t>(4 * 40 * 20, 255)};
  Image actual = expected;
  actual.rgba[4 * (18 * 40 + 35)] = 249;  // in the window of 8 × 4 pixels at the bottom right
  const Difference d = difference(expected, actual);
  CHECK(d.largest_step == 6);
  CHECK(d.worst_window == Approx(6.0 / 3 / (8 * 4)));
  CHECK(pixel(d.picture, 35, 18).g < 150);
  CHECK(same(pixel(d.picture, 34, 18), {255, 255, 255}));

  const Image shorter{40, 10, std::vector<std::uint8_t>(4 * 40 * 10, 255)};
  const Difference other = difference(expected, shorter);
  CHECK_FALSE(other.same_size);
  CHECK(other.largest_step == 255);
  CHECK(other.picture.height == 20);
}

TEST_CASE("a canvas has one scale, its view in the middle, y down") {
  render(small_page, [](Pen& pen) {
    const Canvas canvas(pen, {10, 20, 300, 100}, {-2, -1, 2, 1});
    CHECK(canvas.points_per_metre() == Approx(42));  // 2 m on 100 points but 8 at each edge
    const Point middle = canvas.to_page(0, 0), below = canvas.to_page(0, 1),
                right = canvas.to_page(2, 0);
    CHECK(middle.x == Approx(160));
    CHECK(middle.y == Approx(70));
    CHECK(below.x == Approx(160));
    CHECK(below.y == Approx(112));
    CHECK(right.x == Approx(244));
    CHECK(right.y == Approx(70));
    CHECK_THROWS_AS(Canvas(pen, {0, 0, 10, 10}, {0, 1, 1, 0}), std::invalid_argument);
  });
}

TEST_CASE("labels of arrows cover neither each other nor another arrow") {
  const Color red{255, 0, 0}, blue{0, 0, 255};
  const auto count = [](const Image& image, Color color) {
    int pixels = 0;
    for (int y = 0; y < image.height; ++y)
      for (int x = 0; x < image.width; ++x) pixels += same(pixel(image, x, y), color);
    return pixels;
  };
  const auto draw = [&](bool first, bool second, Point other) {
    return render(small_page, [&](Pen& pen) {
      Canvas canvas(pen, {0, 0, 320, 200}, {-2, -2, 2, 2});
      if (first) canvas.arrow({0, 0}, {0, -1}, red, "weight 1.00 N");
      if (second) canvas.arrow({0, 0}, other, blue, "applied 1.05 N");
    });
  };
  // side by side, head to label, one after the other
  for (const Point other : {Point{0.3, -1.0}, Point{0.35, -1.5}, Point{0.9, 0.0}}) {
    INFO(other.x << ", " << other.y);
    const Image both = draw(true, true, other);
    CHECK(count(both, red) == Approx(count(draw(true, false, other), red)).margin(25));
    CHECK(count(both, blue) == Approx(count(draw(false, true, other), blue)).margin(2));
    CHECK(count(both, red) > 50);
  }
}

TEST_CASE("axes make room for their numbers and so come first") {
  render(small_page, [](Pen& pen) {
    Canvas canvas(pen, {0, 0, 320, 200}, {-1, -1, 1, 1});
    const double before = canvas.points_per_metre();
    canvas.axes("m");
    CHECK(canvas.points_per_metre() < before);
    CHECK(canvas.to_page(-1, -1).y > 10);
    CHECK(canvas.to_page(1, 1).y < 170);
    canvas.pin({0, 0});
    CHECK_THROWS_AS(canvas.axes("m"), std::logic_error);

    Canvas tiny(pen, {0, 0, 20, 20}, {-1, -1, 1, 1});
    tiny.axes("m");
    tiny.force_scale(0.01);
    CHECK(tiny.points_per_metre() > 0);
  });
}

TEST_CASE("shapes land where the canvas says, and nowhere else") {
  const Color fill{200, 0, 0};
  const Image image = render(small_page, [&](Pen& pen) {
    Canvas canvas(pen, {100, 50, 100, 100}, {0, 0, 10, 10});
    canvas.box({5, 5}, 6, 2, std::acos(-1.0) / 2, fill, fill);  // upright
    canvas.disc({0, 10}, 2, fill, fill);                        // a quarter of it is inside
  });
  CHECK(same(pixel(image, 150, 75), fill));
  CHECK_FALSE(same(pixel(image, 175, 100), fill));
  CHECK(same(pixel(image, 105, 145), fill));
  CHECK_FALSE(same(pixel(image, 95, 145), fill));
}

TEST_CASE("a shape's rim is soft over one pixel, half of it outside") {
  const Color black{0, 0, 0};
  const auto box = [&](double shift) {
    return render(small_page, [&](Pen& pen) {
      const Point a{100 + shift, 50}, b{120 + shift, 50}, c{120 + shift, 80}, d{100 + shift, 80};
      pen.polygon(std::array{a, b, c, d}, black);
    });
  };
  const Color paper = theme("light").paper;
  const Image crisp = box(0), halfway = box(0.5);
  for (int x = 95; x < 125; ++x) {
    CHECK(same(pixel(crisp, x, 60), x >= 100 && x < 120 ? black : paper));
    CHECK(same(pixel(crisp, x, 49), paper));
    CHECK(same(pixel(halfway, x, 60), x > 100 && x < 120 ? black : paper) ==
          (x != 100 && x != 120));
  }
  for (const int x : {100, 120}) CHECK(std::abs(pixel(halfway, x, 60).g - paper.g / 2) <= 1);
}

TEST_CASE("shapes and lines cover their area, however they are turned") {
  const auto area = [](const std::function<void(Pen&)>& draw) {
    const Image image = render(small_page, draw);
    double sum = 0;
    for (std::size_t i = 0; i < image.rgba.size(); i += 4)
      sum += 1 - double(image.rgba[i]) / theme("light").paper.r;
    return sum;
  };
  const Color black{0, 0, 0};
  for (double angle = 0; angle < 3.1; angle += 0.3) {
    INFO(angle);
    const Point x{std::cos(angle), std::sin(angle)}, y{-x.y, x.x}, middle{160, 100};
    const auto at = [&](double a, double b) { return middle + a * x + b * y; };
    const std::array box{at(-30, -10), at(30, -10), at(30, 10), at(-30, 10)};
    const std::array other_sense{box[3], box[2], box[1], box[0]};
    const std::array bend{at(-40, 10), at(0, 0), at(40, 10)};
    // A corner's rim holds up to a quarter of a pixel too much or too little.
    CHECK(area([&](Pen& pen) { pen.polygon(box, black); }) == Approx(60 * 20).margin(2));
    CHECK(area([&](Pen& pen) { pen.polygon(other_sense, black); }) == Approx(60 * 20).margin(2));
    CHECK(area([&](Pen& pen) { pen.polygon(box, transparent, black, 4); }) ==
          Approx(2 * 4 * (60 + 20)).margin(2));
    // Both ends are round.
    CHECK(area([&](Pen& pen) { pen.polyline(bend, black, 5); }) ==
          Approx(5 * 2 * std::hypot(40, 10) + 2.5 * 2.5 * std::acos(-1.0)).margin(6));
  }
  CHECK(area([&](Pen& pen) {
          pen.circle({100, 100}, 40, black);
        }) == Approx(40 * 40 * std::acos(-1.0)).epsilon(0.005));
}

TEST_CASE("long, broken and endless lines are drawn") {
  const double nan = std::nan(""), infinity = std::numeric_limits<double>::infinity();
  const Color ink = theme("light").ink;
  const Image image = render(small_page, [&](Pen& pen) {
    std::vector<Point> points;
    for (int i = 0; i < 100'000; ++i) points.push_back({i * 0.0032, 40 + 30 * std::sin(i * 1e-2)});
    pen.polyline(points, ink);
    const std::vector<Point> broken{{10, 100}, {100, 100}, {nan, 100}, {200, 100}, {300, 100}};
    pen.polyline(broken, ink, 4);
    pen.line({-1e300, 150}, {1e300, 150}, ink, 4, Dash::dashed);
    pen.line({160, 120}, {160, infinity}, ink, 4);
    pen.arrow({20, 180}, {20, 180}, ink);
    pen.circle({nan, 0}, 5, ink);
  });
  CHECK(same(pixel(image, 50, 100), ink));
  CHECK_FALSE(same(pixel(image, 150, 100), ink));
  CHECK(same(pixel(image, 250, 100), ink));
  int dashes = 0;
  for (int x = 0; x < 320; ++x) dashes += same(pixel(image, x, 150), ink) ? 1 : 0;
  CHECK(dashes > 100);
  CHECK(dashes < 250);
  CHECK_FALSE(same(pixel(image, 20, 180), ink));
}

TEST_CASE("one or two letters after a letter and _ are a subscript, but not in a name") {
  render({.width = 100, .height = 50, .scale = 10}, [](Pen& pen) {
    const auto width = [&](const char* text) { return pen.text_width(text); };
    const double k = width("k"), d = width("d");
    CHECK(width("k_d") == Approx(k + 0.75 * d).margin(0.2));
    CHECK(width("(k_d k)²") == Approx(width("(k k)²") + 0.75 * d).margin(0.4));
    CHECK(width("k_dd") == Approx(k + 1.5 * d).margin(0.4));
    for (const char* name : {"rk_dd", "kk_d", "k_2_d", "k_ddd", "k_", "_d"}) {
      INFO(name);
      double sum = 0;
      for (const char* c = name; *c != 0; ++c) sum += width(std::string(1, *c).c_str());
      CHECK(width(name) == Approx(sum).margin(0.4));
    }
  });
}

TEST_CASE("every sign that the lessons use has a glyph of its own") {
  render(small_page, [](Pen& pen) {
    const double missing = pen.text_width("\u4e2d");  // no font here has Chinese
    for (const char* sign : {"²", "·", "×", "±", "°", "λ", "ω", "Δ", "⁰", "⁹", "⁻", "₀", "₉", "−",
                             "≈", "≤", "≥", "→", "√", "∇", "∂", "∞", "–", "—", "…", "ẋ", "ᵀ"}) {
      CAPTURE(sign);
      CHECK(pen.text_width(sign) != missing);
    }
  });
}

TEST_CASE("linear ticks are round numbers") {
  using Labels = std::vector<std::string>;
  CHECK(labels(linear_ticks(0, 10, 6)) == Labels{"0", "2", "4", "6", "8", "10"});
  CHECK(labels(linear_ticks(-0.1, 0.11, 4)) == Labels{"−0.1", "0", "0.1"});
  CHECK(labels(linear_ticks(0, 2e6, 3)) == Labels{"0", "1×10⁶", "2×10⁶"});
  CHECK(linear_ticks(1, 1, 5).empty());
  CHECK(linear_ticks(1, std::nextafter(1, 2), 5).empty());
}

TEST_CASE("log ticks are decades, thinned when there are many") {
  using Labels = std::vector<std::string>;
  CHECK(labels(log_ticks(1e-3, 1, 9)) == Labels{"10⁻³", "10⁻²", "10⁻¹", "10⁰"});
  CHECK(labels(log_ticks(2e-13, 3, 5)) == Labels{"10⁻¹²", "10⁻⁹", "10⁻⁶", "10⁻³", "10⁰"});
  CHECK(labels(log_ticks(2, 30, 9)) == Labels{"2", "5", "10", "20"});
  CHECK(labels(log_ticks(1e-9, 4e-9, 9)) == Labels{"10⁻⁹", "2×10⁻⁹"});
  const auto ticks = log_ticks(1, 100, 9);
  CHECK(ticks.size() == 3 + 2 * 8);  // with the minor ones
  for (const Tick& tick : ticks) CHECK((tick.value > 0.99 && tick.value < 101));
}

TEST_CASE("plots draw what they can of any data") {
  const double nan = std::nan("");
  const auto draw_it = [](const Plot& plot) {
    return painted(render(small_page, [&](Pen& pen) { draw_plot(pen, {0, 0, 320, 200}, plot); }));
  };
  const std::size_t empty = draw_it({});
  CHECK(empty > 500);  // its axes
  CHECK(draw_it({.curves = {{.points = {{3, 4}}, .markers = true}}}) > 500);
  CHECK(draw_it({.y = {.log = true}, .curves = {{.points = {{0, 0}, {1, -1}, {2, nan}}}}}) > 500);
  CHECK(draw_it({.y = {.log = true}, .curves = {{.points = {{0, 1e-300}, {1, 1e300}}}}}) > 500);
  CHECK(draw_it({.x = {.max = -5.0}, .curves = {{.label = "right", .points = {{1, 1}, {2, 2}}}}}) >
        500);
  CHECK_THROWS_AS(draw_it({.x = {.min = 2.0, .max = 1.0}}), std::invalid_argument);
  CHECK_THROWS_AS(draw_it({.y = {.log = true, .min = 0.0}}), std::invalid_argument);
  CHECK_THROWS_AS(draw_it({.y = {.max = nan}}), std::invalid_argument);
  CHECK_THROWS_AS(draw_it({.slopes = {{1, "", {1, 1}}}}), std::invalid_argument);
}

TEST_CASE("a theme is light or dark") {
  CHECK(theme("dark").name == "dark");
  CHECK_THROWS_AS(theme("sepia"), std::invalid_argument);
  CHECK(theme("light").ink.faded(0.5).a == 128);
}

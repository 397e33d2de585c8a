#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "instruments/draw/pen.hpp"

namespace draw {

/// A window with pages on the left, drawn by a Pen as pictures are, and a panel of controls at the
/// right. All places are in points, which are pixels here.
///
/// In the book (window_web.cpp) it is a part of a page of the web: a canvas, as wide as there is
/// room, and the controls beside or below it, where the page puts them.
class Window {
 public:
  enum class Key { space, right, r, s };
  struct Mouse {
    Point at;
    bool pressed, down;  ///< on the pages; what happens on the panel is the panel's
  };
  /// The values between which a slider moves.
  struct Span {
    double low, high;
    bool log = false, whole = false;
  };

  /// As large as given, or as the screen has room for.
  /// Throws std::runtime_error: "no display" where there is none, or what OpenGL lacks.
  Window(const std::string& title, int width, int height, double panel_width, const Theme& theme);
  ~Window();
  Window(const Window&) = delete;
  Window& operator=(const Window&) = delete;

  /// Frame after frame, at most 60 of them a second, until it is closed, or Escape pressed outside
  /// a list and what is typed; in the book it does not return. `draw` is told how long ago the last
  /// frame was [s]; all that follows is for it to call.
  void run(const std::function<void(double)>& draw);
  /// What the last frame took, without waiting for the screen [s].
  double frame_seconds() const;

  const Theme& theme() const;
  double pages_width() const;
  double height() const;
  /// For a page that begins at the window's top left.
  Pen pen(double width, double height) const;
  Mouse mouse() const;
  /// How often the key was pressed since the last frame; right and s repeat while they are held.
  int presses(Key key) const;

  // The controls of the panel; their places count from its top left. A control's name is shown on
  // it or, where it has none to show, at its left, as a label.
  bool button(const Rect& place, const std::string& text, bool enabled = true);
  bool check(const Rect& place, const std::string& text, bool& checked);
  void label(const Rect& place, const std::string& name);
  /// With its value and unit written on it, which can be typed, be it beyond the span, and Enter
  /// takes it. True when it is let go after it was moved.
  bool slider(const Rect& place, const std::string& name, double& value, const Span& span,
              const std::string& unit, bool enabled = true);
  bool choice(const Rect& place, const std::string& name, const std::vector<std::string>& texts,
              int& chosen);
  /// How a value is typed and what else only this kind of window has, for those who use it.
  static const char* const usage;
  /// Broken into lines between words.
  void text(const Rect& place, const std::string& utf8, const Color& color);

 private:
  struct Inside;
  std::unique_ptr<Inside> inside_;
};

}  // namespace draw

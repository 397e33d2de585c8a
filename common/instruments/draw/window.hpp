#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "instruments/draw/pen.hpp"

namespace draw {

/// A window with pages on the left, drawn by a Pen as pictures are, and a panel of controls at the
/// right. All places are in points, which are pixels here.
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

  /// Until it was closed, or Escape pressed outside a list and what is typed.
  bool open() const;
  /// One frame, at most 60 of them a second. All that follows is for `draw` to call.
  void frame(const std::function<void()>& draw);
  /// What the last frame took, without waiting for the screen [s].
  double frame_seconds() const;

  double pages_width() const;
  double height() const;
  /// For a page that begins at the window's top left.
  Pen pen(double width, double height) const;
  Mouse mouse() const;
  /// How often the key was pressed since the last frame; right and s repeat while they are held.
  int presses(Key key) const;

  // The controls of the panel; their places count from its top left. A control's name is shown on
  // it or, where it has none to show, at its left.
  bool button(const Rect& place, const std::string& text, bool enabled = true);
  bool check(const Rect& place, const std::string& text, bool& checked);
  /// With its value and unit written on it; a click with the control key lets it be typed, be it
  /// beyond the span, and Enter takes it. True when it is let go after it was moved.
  bool slider(const Rect& place, const std::string& name, double& value, const Span& span,
              const std::string& unit, bool enabled = true);
  bool choice(const Rect& place, const std::string& name, const std::vector<std::string>& texts,
              int& chosen);
  /// Broken into lines between words.
  void text(const Rect& place, const std::string& utf8, const Color& color);

 private:
  struct Inside;
  std::unique_ptr<Inside> inside_;
};

}  // namespace draw

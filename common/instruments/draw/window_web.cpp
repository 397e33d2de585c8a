// In place of window.cpp in the book: the canvas and the controls are those of a page of the web.
// The page's script, which started this program, has them at hand as Module.page
// (app/book/scene.js).

#include <emscripten.h>
#include <imgui.h>

#include <cmath>
#include <cstdint>

#include "instruments/draw/window.hpp"

namespace {

/// What the page knows before each frame, as scene.js writes it: the canvas in points, pixels in a
/// point, whether the reader likes it dark, the pointer, and how often each Key was pressed.
struct State {
  double width, height, scale, dark, x, y, pressed, down;
  double presses[4];
};

std::function<void(double)> next_frame;

}  // namespace

// clang-format off
EM_JS(void, page_starts, (), { Module.page.starts(); })
EM_JS(void, page_state, (double* state), { HEAPF64.set(Module.page.state(), state / 8); })
EM_JS(void, page_clear, (int r, int g, int b), { Module.page.clear(r, g, b); })
EM_JS(void, page_texture, (const std::uint8_t* coverage, int width, int height), {
  Module.page.texture(HEAPU8.subarray(coverage, coverage + width * height), width, height);
})
EM_JS(void, page_mesh, (const void* vertices, int size, const void* indices, int count), {
  Module.page.mesh(HEAPU8.subarray(vertices, vertices + size), HEAPU16.subarray(indices / 2, indices / 2 + count));
})
EM_JS(void, page_fill, (int first, int count, int vertex, double left, double top, double right, double bottom), {
  Module.page.fill(first, count, vertex, left, top, right, bottom);
})
EM_JS(bool, page_button, (const char* text, int place, bool enabled), {
  return Module.page.button(UTF8ToString(text), place, !!enabled);
})
EM_JS(bool, page_check, (const char* name, bool checked), {
  return Module.page.check(UTF8ToString(name), !!checked);
})
EM_JS(bool, page_slider, (const char* name, double* value, double low, double high, bool log, bool whole,
                          const char* unit, bool enabled), {
  const now = Module.page.slider(UTF8ToString(name), HEAPF64[value / 8], low, high, log, whole,
                                 UTF8ToString(unit), !!enabled);
  HEAPF64[value / 8] = now.value;
  return now.rests;
})
EM_JS(int, page_choice, (const char* name, const char* texts, int chosen), {
  return Module.page.choice(UTF8ToString(name), UTF8ToString(texts).split('\n'), chosen);
})
EM_JS(void, page_text, (const char* text, int r, int g, int b), {
  Module.page.text(UTF8ToString(text), r, g, b);
})
// clang-format on

namespace draw {

struct Window::Inside {
  ImGuiContext* gui = ImGui::CreateContext();
  Theme theme;
  Fonts fonts{};
  double fonts_scale = 0.0;
  State state{};
  double frame_seconds = 0.0;

  explicit Inside(const Theme& colors) : theme(colors) {
    ImGui::GetIO().IniFilename = nullptr;
    ImGui::GetIO().BackendFlags |= ImGuiBackendFlags_RendererHasVtxOffset;
    ImGui::GetStyle().AntiAliasedLinesUseTex = false;  // as in the pictures
    look();
  }
  ~Inside() { ImGui::DestroyContext(gui); }

  void look() {
    page_state(&state.width);
    theme = draw::theme(state.dark != 0.0 ? "dark" : "light");
    if (state.scale == fonts_scale) return;
    fonts_scale = state.scale;
    ImFontAtlas& atlas = *ImGui::GetIO().Fonts;
    atlas.Clear();
    fonts = load_fonts(fonts_scale);
    unsigned char* coverage = nullptr;
    int width = 0, height = 0;
    atlas.GetTexDataAsAlpha8(&coverage, &width, &height);
    page_texture(coverage, width, height);
  }

  void frame(const std::function<void(double)>& draw, double wall) {
    const double start = emscripten_get_now();
    look();
    ImGui::GetIO().DisplaySize = {static_cast<float>(state.width * state.scale),
                                  static_cast<float>(state.height * state.scale)};
    ImGui::NewFrame();
    draw(wall);
    ImGui::Render();
    frame_seconds = 1e-3 * (emscripten_get_now() - start);
    page_clear(theme.paper.r, theme.paper.g, theme.paper.b);
    const ImDrawData& drawn = *ImGui::GetDrawData();
    for (int i = 0; i < drawn.CmdListsCount; ++i) {
      const ImDrawList& list = *drawn.CmdLists[i];
      page_mesh(list.VtxBuffer.Data, list.VtxBuffer.size_in_bytes(), list.IdxBuffer.Data,
                list.IdxBuffer.Size);
      for (const ImDrawCmd& command : list.CmdBuffer)
        page_fill(static_cast<int>(command.IdxOffset), static_cast<int>(command.ElemCount),
                  static_cast<int>(command.VtxOffset), command.ClipRect.x, command.ClipRect.y,
                  command.ClipRect.z, command.ClipRect.w);
    }
  }
};

Window::Window(const std::string&, int, int, double, const Theme& theme)
    : inside_(std::make_unique<Inside>(theme)) {}

Window::~Window() = default;

extern "C" EMSCRIPTEN_KEEPALIVE void frame(double wall) { next_frame(wall); }

/// The browser calls for each frame, and can only do so when main has been left. Returning from it,
/// or throwing, would end the scene that stands in the frames of the stack; a trap leaves all of
/// them as they are.
void Window::run(const std::function<void(double)>& draw) {
  next_frame = [this, draw](double wall) { inside_->frame(draw, wall); };
  page_starts();
  __builtin_trap();
}

double Window::frame_seconds() const { return inside_->frame_seconds; }

const Theme& Window::theme() const { return inside_->theme; }

double Window::pages_width() const { return inside_->state.width; }

double Window::height() const { return inside_->state.height; }

Pen Window::pen(double width, double height) const {
  return {ImGui::GetBackgroundDrawList(),
          inside_->fonts,
          inside_->theme,
          width,
          height,
          inside_->state.scale};
}

Window::Mouse Window::mouse() const {
  const State& state = inside_->state;
  return {{state.x, state.y}, state.pressed != 0.0, state.down != 0.0};
}

int Window::presses(Key key) const {
  return static_cast<int>(inside_->state.presses[static_cast<std::size_t>(key)]);
}

bool Window::button(const Rect& place, const std::string& text, bool enabled) {
  return page_button(text.c_str(), static_cast<int>(place.left), enabled);
}

bool Window::check(const Rect&, const std::string& text, bool& checked) {
  const std::string name = text.starts_with("##") ? text.substr(2) : text;
  const bool toggled = page_check(name.c_str(), checked);
  checked ^= toggled;
  return toggled;
}

void Window::label(const Rect&, const std::string&) {}  // the page's controls have their names

bool Window::slider(const Rect&, const std::string& name, double& value, const Span& span,
                    const std::string& unit, bool enabled) {
  const double before = value;
  const bool rests = page_slider(name.c_str(), &value, span.low, span.high, span.log, span.whole,
                                 unit.c_str(), enabled);
  if (span.whole && value != before) value = std::round(value);
  return rests;
}

bool Window::choice(const Rect&, const std::string& name, const std::vector<std::string>& texts,
                    int& chosen) {
  std::string all;
  for (const std::string& text : texts) all += (all.empty() ? "" : "\n") + text;
  const int before = chosen;
  chosen = page_choice(name.c_str(), all.c_str(), before);
  return chosen != before;
}

const char* const Window::usage = "A value can be typed into its box. Escape closes the scene.";

void Window::text(const Rect&, const std::string& utf8, const Color& color) {
  page_text(utf8.c_str(), color.r, color.g, color.b);
}

}  // namespace draw

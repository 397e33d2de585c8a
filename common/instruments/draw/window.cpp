#include "instruments/draw/window.hpp"

#include <GLFW/glfw3.h>
#include <backends/imgui_impl_glfw.h>
#include <backends/imgui_impl_opengl3.h>
#include <imgui.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <optional>
#include <set>
#include <stdexcept>
#include <thread>
#include <utility>

namespace draw {
namespace {

using Clock = std::chrono::steady_clock;
using Seconds = std::chrono::duration<double>;
constexpr Seconds shortest_frame{1.0 / 60.0};

ImVec2 pixels(double x, double y) { return {static_cast<float>(x), static_cast<float>(y)}; }

ImVec4 color(const Color& c) {
  return ImGui::ColorConvertU32ToFloat4(IM_COL32(c.r, c.g, c.b, c.a));
}

#ifdef GLFW_PLATFORM  // GLFW 3.4 and later, which know Wayland too
/// Whether there can be a Wayland server; where not, its library says so itself when it is asked.
bool can_have_wayland() {
  const auto is_path = [](const char* text) { return text != nullptr && text[0] == '/'; };
  return is_path(std::getenv("XDG_RUNTIME_DIR")) || is_path(std::getenv("WAYLAND_DISPLAY"));
}
#endif

/// No larger than the primary screen has room for, frame and all, and nothing of it outside.
void fit_inside_screen(GLFWwindow* window, int width, int height) {
  int least_width = 960, least_height = 600;
  int left = 0, top = 0, wide = 0, high = 0;
  if (GLFWmonitor* screen = glfwGetPrimaryMonitor(); screen != nullptr)
    glfwGetMonitorWorkarea(screen, &left, &top, &wide, &high);
  if (wide > 0 && high > 0) {
    std::array<int, 4> frame{};  // left, top, right, bottom
    glfwGetWindowFrameSize(window, &frame[0], &frame[1], &frame[2], &frame[3]);
    left += frame[0], top += frame[1];
    wide = std::max(1, wide - frame[0] - frame[2]), high = std::max(1, high - frame[1] - frame[3]);
    least_width = std::min(least_width, wide), least_height = std::min(least_height, high);
    width = std::min(width, wide), height = std::min(height, high);
    int x = 0, y = 0;
    glfwGetWindowPos(window, &x, &y);
    glfwSetWindowSize(window, width, height);
    glfwSetWindowPos(window, std::clamp(x, left, left + wide - width),
                     std::clamp(y, top, top + high - height));
  }
  glfwSetWindowSizeLimits(window, least_width, least_height, GLFW_DONT_CARE, GLFW_DONT_CARE);
}

}  // namespace

struct Window::Inside {
  GLFWwindow* window = nullptr;
  ImGuiContext* gui = nullptr;
  double panel_width;
  Theme theme;
  Fonts fonts{};
  std::array<int, 4> presses{};  // of each Key
  bool escaped = false;          // since the last frame, as they
  struct Release {
    int key, code, modifiers;
  };
  std::set<int> down{};         // keys that went down since the last frame
  std::vector<Release> late{};  // those of them that went up too
  struct Typed {
    std::string slider;
    double value;
  };
  std::optional<Typed> typed{};  // on a slider, and not yet taken
  double frame_seconds = 0.0;
  Clock::time_point next_frame = Clock::now();

  void frame(const Window& all, const std::function<void()>& draw);

  Inside(double panel, const Theme& colors) : panel_width(panel), theme(colors) {}
  ~Inside() {
    if (gui != nullptr) {
      ImGui_ImplOpenGL3_Shutdown();
      ImGui_ImplGlfw_Shutdown();
      ImGui::DestroyContext(gui);
    }
    glfwTerminate();
  }

  // Dear ImGui looks at the keys once a frame: a key that goes down and up between two frames goes
  // up after the second for it.
  static void on_key(GLFWwindow* window, int key, int code, int action, int modifiers) {
    auto& inside = *static_cast<Inside*>(glfwGetWindowUserPointer(window));
    if (action == GLFW_RELEASE && inside.down.contains(key))
      inside.late.push_back({key, code, modifiers});
    else
      ImGui_ImplGlfw_KeyCallback(window, key, code, action, modifiers);
    if (action == GLFW_RELEASE) return;
    inside.down.insert(key);
    if (key == GLFW_KEY_ESCAPE) inside.escaped = true;
    if (ImGui::GetIO().WantTextInput) return;
    if ((modifiers & (GLFW_MOD_CONTROL | GLFW_MOD_ALT | GLFW_MOD_SUPER)) != 0) return;
    if (action == GLFW_REPEAT && (key == GLFW_KEY_SPACE || key == GLFW_KEY_R)) return;
    if (key == GLFW_KEY_ESCAPE && !ImGui::IsPopupOpen("", ImGuiPopupFlags_AnyPopup))
      glfwSetWindowShouldClose(window, GLFW_TRUE);
    constexpr std::array keys{GLFW_KEY_SPACE, GLFW_KEY_RIGHT, GLFW_KEY_R, GLFW_KEY_S};
    for (std::size_t i = 0; i < keys.size(); ++i)
      if (key == keys[i]) ++inside.presses[i];
  }
  // A decimal comma is a point; Dear ImGui would drop it.
  static void on_char(GLFWwindow* window, unsigned c) {
    ImGui_ImplGlfw_CharCallback(window, c == ',' ? '.' : c);
  }
};

Window::Window(const std::string& title, int width, int height, double panel_width,
               const Theme& theme)
    : inside_(std::make_unique<Inside>(panel_width, theme)) {
#ifdef GLFW_PLATFORM
  if (!can_have_wayland()) glfwInitHint(GLFW_PLATFORM, GLFW_PLATFORM_X11);
#endif
  if (glfwInit() == GLFW_FALSE) throw std::runtime_error("no display");
  glfwWindowHint(GLFW_CONTEXT_VERSION_MAJOR, 3);
  glfwWindowHint(GLFW_CONTEXT_VERSION_MINOR, 3);
  glfwWindowHint(GLFW_OPENGL_PROFILE, GLFW_OPENGL_CORE_PROFILE);
  inside_->window = glfwCreateWindow(width, height, title.c_str(), nullptr, nullptr);
  if (inside_->window == nullptr) throw std::runtime_error("no window with OpenGL 3.3");
  fit_inside_screen(inside_->window, width, height);
  glfwSetWindowUserPointer(inside_->window, inside_.get());
  glfwMakeContextCurrent(inside_->window);
  glfwSwapInterval(1);
  inside_->gui = ImGui::CreateContext();
  ImGui::SetCurrentContext(inside_->gui);
  ImGui::GetIO().IniFilename = nullptr;  // write no file
  ImGui::StyleColorsLight();
  for (const auto part : {ImGuiCol_SliderGrab, ImGuiCol_SliderGrabActive})
    ImGui::GetStyle().Colors[part].w = 0.35F;        // the value stands on it
  ImGui::GetStyle().AntiAliasedLinesUseTex = false;  // as in the pictures
  inside_->fonts = load_fonts(1.0);
  ImGui::GetIO().FontDefault = inside_->fonts[static_cast<std::size_t>(Font::small)];
  ImGui_ImplGlfw_InitForOpenGL(inside_->window, true);
  glfwSetKeyCallback(inside_->window, Inside::on_key);
  glfwSetCharCallback(inside_->window, Inside::on_char);
  if (!ImGui_ImplOpenGL3_Init("#version 330"))
    throw std::runtime_error("no window with OpenGL 3.3");
}

Window::~Window() = default;

void Window::run(const std::function<void(double)>& draw) {
  Clock::time_point last = Clock::now();
  while (glfwWindowShouldClose(inside_->window) == GLFW_FALSE) {
    const Clock::time_point now = Clock::now();
    inside_->frame(*this, [&] { draw(Seconds(now - last).count()); });
    last = now;
  }
}

void Window::Inside::frame(const Window& all, const std::function<void()>& draw) {
  presses = {};
  escaped = false;
  down.clear();
  for (const auto& [key, code, modifiers] : std::exchange(late, {}))
    ImGui_ImplGlfw_KeyCallback(window, key, code, GLFW_RELEASE, modifiers);
  glfwPollEvents();
  const Clock::time_point start = Clock::now();
  ImGui_ImplOpenGL3_NewFrame();
  ImGui_ImplGlfw_NewFrame();
  ImGui::NewFrame();
  ImGui::SetNextWindowPos(pixels(all.pages_width(), 0.0));
  ImGui::SetNextWindowSize(pixels(panel_width, all.height()));
  ImGui::Begin("controls", nullptr,
               ImGuiWindowFlags_NoTitleBar | ImGuiWindowFlags_NoResize | ImGuiWindowFlags_NoMove |
                   ImGuiWindowFlags_NoCollapse | ImGuiWindowFlags_NoSavedSettings);
  draw();
  ImGui::End();
  ImGui::Render();
  int width = 0, height = 0;
  glfwGetFramebufferSize(window, &width, &height);
  const Color paper = theme.paper;
  glViewport(0, 0, width, height);
  glClearColor(paper.r / 255.0F, paper.g / 255.0F, paper.b / 255.0F, 1);
  glClear(GL_COLOR_BUFFER_BIT);
  ImGui_ImplOpenGL3_RenderDrawData(ImGui::GetDrawData());
  glFinish();  // else a slow renderer would go on into the time of the next frame
  frame_seconds = Seconds(Clock::now() - start).count();
  glfwSwapBuffers(window);
  // Not every display makes the swap wait for it.
  std::this_thread::sleep_until(next_frame);
  next_frame = Clock::now() + std::chrono::duration_cast<Clock::duration>(0.95 * shortest_frame);
}

double Window::frame_seconds() const { return inside_->frame_seconds; }

const Theme& Window::theme() const { return inside_->theme; }

double Window::pages_width() const {
  return std::max(1.0, double{ImGui::GetIO().DisplaySize.x} - inside_->panel_width);
}

double Window::height() const { return std::max(1.0, double{ImGui::GetIO().DisplaySize.y}); }

Pen Window::pen(double width, double height) const {
  return {ImGui::GetBackgroundDrawList(), inside_->fonts, inside_->theme, width, height, 1.0};
}

Window::Mouse Window::mouse() const {
  const ImGuiIO& io = ImGui::GetIO();
  const bool ours = !io.WantCaptureMouse;
  return {{io.MousePos.x, io.MousePos.y}, ours && ImGui::IsMouseClicked(0), ImGui::IsMouseDown(0)};
}

int Window::presses(Key key) const { return inside_->presses[static_cast<std::size_t>(key)]; }

bool Window::button(const Rect& place, const std::string& text, bool enabled) {
  ImGui::SetCursorPos(pixels(place.left, place.top));
  ImGui::BeginDisabled(!enabled);
  const bool pressed = ImGui::Button(text.c_str(), pixels(place.width, place.height));
  ImGui::EndDisabled();
  return pressed;
}

bool Window::check(const Rect& place, const std::string& text, bool& checked) {
  ImGui::SetCursorPos(pixels(place.left, place.top));
  return ImGui::Checkbox(text.c_str(), &checked);
}

void Window::label(const Rect& place, const std::string& name) { text(place, name, theme().ink); }

bool Window::slider(const Rect& place, const std::string& name, double& value, const Span& span,
                    const std::string& unit, bool enabled) {
  ImGui::SetCursorPos(pixels(place.left, place.top));
  ImGui::SetNextItemWidth(static_cast<float>(place.width));
  const std::string format = "%.4g " + unit;
  auto& typed = inside_->typed;
  const bool ours = typed && typed->slider == name;
  double shown = ours ? typed->value : value;
  ImGui::BeginDisabled(!enabled);
  const bool moved = ImGui::SliderScalar(
      ("##" + name).c_str(), ImGuiDataType_Double, &shown, &span.low, &span.high, format.c_str(),
      ImGuiSliderFlags_NoRoundToFormat | (span.log ? ImGuiSliderFlags_Logarithmic : 0));
  ImGui::EndDisabled();
  const bool let_go = ImGui::IsItemDeactivatedAfterEdit();
  // Half a number is another number, so what is typed counts at its end.
  if (moved && !let_go && ImGui::GetIO().WantTextInput)
    typed = {name, shown};
  else if ((moved || (ours && let_go)) && !inside_->escaped)
    value = span.whole ? std::round(shown) : shown;
  if (ours && let_go) typed.reset();
  return let_go;
}

bool Window::choice(const Rect& place, const std::string& name,
                    const std::vector<std::string>& texts, int& chosen) {
  ImGui::SetCursorPos(pixels(place.left, place.top));
  ImGui::SetNextItemWidth(static_cast<float>(place.width));
  const int before = chosen;
  if (!ImGui::BeginCombo(("##" + name).c_str(), texts[static_cast<std::size_t>(chosen)].c_str()))
    return false;
  for (int i = 0; i < static_cast<int>(texts.size()); ++i)
    if (ImGui::Selectable(texts[static_cast<std::size_t>(i)].c_str(), i == before)) chosen = i;
  if (inside_->escaped) ImGui::CloseCurrentPopup();
  ImGui::EndCombo();
  return chosen != before;
}

const char* const Window::usage = "Ctrl-click a slider to type its value.";

void Window::text(const Rect& place, const std::string& utf8, const Color& ink) {
  // Dear ImGui would break a line at the point of a number.
  std::string lines;
  for (const std::string& line : pen(1.0, 1.0).wrap(utf8, Font::small, place.width))
    lines += (lines.empty() ? "" : "\n") + line;
  ImGui::SetCursorPos(pixels(place.left, place.top));
  ImGui::PushStyleColor(ImGuiCol_Text, color(ink));
  ImGui::TextUnformatted(lines.c_str());
  ImGui::PopStyleColor();
}

}  // namespace draw

#include "instruments/draw/offscreen.hpp"

#include <imgui.h>

#include <cmath>
#include <stdexcept>
#include <utility>

#include "instruments/draw/raster.hpp"

namespace draw {
namespace {

constexpr int largest = 16384;  // pixels of a side, of the picture and of the fonts' texture

// Runs an action when the scope is left, by an exception too.
struct Finally {
  std::function<void()> action;
  explicit Finally(std::function<void()> a) : action(std::move(a)) {}
  Finally(const Finally&) = delete;
  Finally& operator=(const Finally&) = delete;
  ~Finally() { action(); }
};

int pixels(int points, double scale) {
  const double count = std::round(points * scale);
  if (count >= 1 && count <= largest) return static_cast<int>(count);
  throw std::invalid_argument("a picture of " + std::to_string(points) + " points at scale " +
                              std::to_string(scale) + " has no side of 1 to " +
                              std::to_string(largest) + " pixels");
}

Image blank(int width, int height, Color paper) {
  Image image{width, height, {}};
  image.rgba.resize(4 * static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
  for (auto pixel = image.rgba.begin(); pixel != image.rgba.end(); pixel += 4)
    std::copy_n(std::array<std::uint8_t, 4>{paper.r, paper.g, paper.b, 255}.begin(), 4, pixel);
  return image;
}

Corner corner(const ImDrawVert& vertex) {
  return {vertex.pos.x, vertex.pos.y, vertex.uv.x, vertex.uv.y,
          double(vertex.col >> IM_COL32_A_SHIFT & 255)};
}

// Of one colour, as all that a Pen draws: only its opacity differs between the corners.
Color color(const ImDrawVert& vertex) {
  const auto channel = [&](int shift) { return static_cast<std::uint8_t>(vertex.col >> shift); };
  return {channel(IM_COL32_R_SHIFT), channel(IM_COL32_G_SHIFT), channel(IM_COL32_B_SHIFT)};
}

void fill(Image& image, const ImDrawList& list, const Texture& texture) {
  for (const ImDrawCmd& command : list.CmdBuffer) {
    const ImVec4& area = command.ClipRect;
    const PixelRect clip{first_pixel(area.x, 0, image.width), first_pixel(area.y, 0, image.height),
                         first_pixel(area.z, 0, image.width), first_pixel(area.w, 0, image.height)};
    const ImDrawVert* vertices = list.VtxBuffer.Data + command.VtxOffset;
    const ImDrawIdx* index = list.IdxBuffer.Data + command.IdxOffset;
    for (unsigned i = 0; i < command.ElemCount; i += 3) {
      const ImDrawVert &a = vertices[index[i]], &b = vertices[index[i + 1]],
                       &c = vertices[index[i + 2]];
      fill_triangle(image, clip, texture, color(a), {corner(a), corner(b), corner(c)});
    }
  }
}

// Kept for the process, since to make the fonts takes far longer than to draw a frame.
class Offscreen {
 public:
  Offscreen() {
    const Finally leave = enter();
    ImGuiIO& io = ImGui::GetIO();
    io.IniFilename = nullptr;  // write no file
    io.BackendFlags |= ImGuiBackendFlags_RendererHasVtxOffset;
    ImGui::GetStyle().AntiAliasedLinesUseTex = false;
  }
  Offscreen(const Offscreen&) = delete;
  Offscreen& operator=(const Offscreen&) = delete;
  ~Offscreen() { ImGui::DestroyContext(gui_); }

  Image render(const Page& page, const std::function<void(Pen&)>& draw) {
    const Finally leave = enter();
    const int width = pixels(page.width, page.scale), height = pixels(page.height, page.scale);
    prepare_fonts(page.scale);
    ImGui::GetIO().DisplaySize = {static_cast<float>(width), static_cast<float>(height)};
    ImGui::NewFrame();
    {
      const Finally end_frame([] { ImGui::EndFrame(); });
      Pen pen(ImGui::GetBackgroundDrawList(), fonts_, page.theme, page.width, page.height,
              page.scale);
      pen.show_caption(page.captions);
      draw(pen);
    }
    ImGui::Render();
    Image image = blank(width, height, page.theme.paper);
    const ImDrawData& drawn = *ImGui::GetDrawData();
    for (int i = 0; i < drawn.CmdListsCount; ++i) fill(image, *drawn.CmdLists[i], texture_);
    return image;
  }

 private:
  // Makes the context current, and gives a window's own back afterwards.
  [[nodiscard]] Finally enter() {
    ImGuiContext* before = ImGui::GetCurrentContext();
    if (before == gui_) before = nullptr;
    ImGui::SetCurrentContext(gui_);
    return Finally([before] { ImGui::SetCurrentContext(before); });
  }

  void prepare_fonts(double scale) {
    if (scale == font_scale_) return;
    font_scale_ = 0;
    ImFontAtlas* atlas = ImGui::GetIO().Fonts;
    atlas->Clear();
    fonts_ = load_fonts(scale);
    unsigned char* coverage = nullptr;
    atlas->GetTexDataAsAlpha8(&coverage, &texture_.width, &texture_.height);
    texture_.coverage = coverage;
    if (std::max(texture_.width, texture_.height) > largest) {
      throw std::invalid_argument("the fonts at scale " + std::to_string(scale) +
                                  " do not fit into a texture: use a smaller scale");
    }
    font_scale_ = scale;
  }

  ImGuiContext* gui_ = ImGui::CreateContext();
  double font_scale_ = 0;
  Fonts fonts_{};
  Texture texture_{};
};

}  // namespace

Image render(const Page& page, const std::function<void(Pen&)>& draw) {
  static Offscreen offscreen;
  return offscreen.render(page, draw);
}

}  // namespace draw

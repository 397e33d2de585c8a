#include "program/files.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <stdexcept>

namespace program {
namespace {

[[noreturn]] void fail(const std::filesystem::path& path, int error) {
  throw std::runtime_error(fmt::format("cannot write {}: {}", path.string(), std::strerror(error)));
}

}  // namespace

NewFile::NewFile(std::filesystem::path path)
    : path_(std::move(path)), beside_(fmt::format("{}.{}.part", path_.string(), getpid())) {
  // A rename would put a folder's or a device's name to the new file; such a name is a mistake.
  std::error_code ignored;
  if (std::filesystem::exists(path_, ignored) && !std::filesystem::is_regular_file(path_, ignored))
    throw std::runtime_error(fmt::format("cannot write {}: it is not a file", path_.string()));
  errno = 0;
  stream_.open(beside_, std::ios::binary | std::ios::trunc);
  if (!stream_) fail(path_, errno);
}

NewFile::~NewFile() {
  if (beside_.empty()) return;
  stream_.close();
  std::error_code ignored;
  std::filesystem::remove(beside_, ignored);
}

void NewFile::write(std::string_view text) {
  errno = 0;
  stream_.write(text.data(), static_cast<std::streamsize>(text.size()));
  if (!stream_) fail(path_, errno);
}

void NewFile::commit() {
  errno = 0;
  stream_.close();
  if (!stream_) fail(path_, errno);
  std::error_code error;
  std::filesystem::rename(beside_, path_, error);
  if (error) fail(path_, error.value());
  beside_.clear();
}

void write_file(const std::filesystem::path& path, std::string_view content) {
  NewFile file(path);
  file.write(content);
  file.commit();
}

void make_folder(const std::filesystem::path& folder) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error)
    throw std::runtime_error(
        fmt::format("cannot make the folder {}: {}", folder.string(), error.message()));
  NewFile(folder / "probe");  // opened and dropped: the folder takes files
}

}  // namespace program

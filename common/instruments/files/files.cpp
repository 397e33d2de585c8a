#include "instruments/files/files.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <stdexcept>

namespace files {
namespace {

[[noreturn]] void fail(const std::filesystem::path& path, int error) {
  throw std::runtime_error(
      fmt::format("cannot write {}: {}; try another place", path.string(), std::strerror(error)));
}

/// The file that a signal must not leave behind; only what a signal handler may touch.
std::array<char, 4096> unfinished{};

void remove_unfinished(int signal) {
  if (unfinished[0] != '\0') unlink(unfinished.data());
  std::signal(signal, SIG_DFL);
  std::raise(signal);
}

void remember_for_signals(const std::string& path) {
  unfinished[0] = '\0';
  if (path.size() >= unfinished.size()) return;
  std::copy(path.begin(), path.end(), unfinished.begin());
  unfinished[path.size()] = '\0';
  for (const int signal : {SIGINT, SIGTERM, SIGHUP, SIGPIPE, SIGXCPU, SIGXFSZ})
    if (std::signal(signal, path.empty() ? SIG_DFL : remove_unfinished) == SIG_IGN)
      std::signal(signal, SIG_IGN);  // as nohup wants it
}

}  // namespace

NewFile::NewFile(std::filesystem::path path) : path_(std::move(path)) {
  // A rename would put a link's, a folder's or a device's name to the new file. A link is followed;
  // the others are a mistake.
  std::error_code error;
  if (std::filesystem::is_symlink(path_, error)) {
    path_ = std::filesystem::canonical(path_, error);
    if (error) fail(path_, error.value());
  }
  if (std::filesystem::exists(path_, error) && !std::filesystem::is_regular_file(path_, error))
    throw std::runtime_error(fmt::format("cannot write {}: it is not a file", path_.string()));
  beside_ = fmt::format("{}.{}.part", path_.string(), getpid());
  remember_for_signals(beside_.string());
  errno = 0;
  stream_.open(beside_, std::ios::binary | std::ios::trunc);
  if (!stream_) {
    remember_for_signals("");
    fail(path_, errno);
  }
}

NewFile::~NewFile() {
  if (beside_.empty()) return;
  stream_.close();
  std::error_code ignored;
  std::filesystem::remove(beside_, ignored);
  remember_for_signals("");
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
  remember_for_signals("");
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
  NewFile(folder / ".writable");  // opened and dropped: the folder takes files
}

}  // namespace files

#pragma once

#include <filesystem>
#include <fstream>
#include <string>
#include <string_view>

namespace files {

/// A file that appears under its name only when it is complete: it is written beside, then renamed.
/// Dropped without `commit`, it leaves nothing behind.
/// Every member throws std::runtime_error, naming the file and the reason.
class NewFile {
 public:
  explicit NewFile(std::filesystem::path path);
  ~NewFile();
  NewFile(const NewFile&) = delete;
  NewFile& operator=(const NewFile&) = delete;

  void write(std::string_view text);
  void commit();

 private:
  std::filesystem::path path_, beside_;
  std::ofstream stream_;
};

/// Writes the whole of a file at once, as above.
void write_file(const std::filesystem::path& path, std::string_view content);

/// Makes the folder where it is missing and makes sure that files can be written there.
/// Throws std::runtime_error with the reason.
void make_folder(const std::filesystem::path& folder);

}  // namespace files

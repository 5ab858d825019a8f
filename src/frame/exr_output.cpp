#include "frame/exr_output.h"

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <memory>
#include <stdexcept>
#include <string>

#include "core/file_io.h"

namespace ld {
namespace {

class OutputStream : public Imf::OStream {
 public:
  OutputStream(const std::string& temporary, const std::string& path)
      : OStream(path.c_str()), file_(std::fopen(temporary.c_str(), "wb"), std::fclose) {
    require(file_ != nullptr);
  }

  void write(const char* bytes, int count) override {
    const auto wanted = static_cast<size_t>(count);
    require(std::fwrite(bytes, 1, wanted, file_.get()) == wanted);
  }
  uint64_t tellp() override {
    const off_t place = ftello(file_.get());
    require(place >= 0);
    return static_cast<uint64_t>(place);
  }
  void seekp(uint64_t place) override {
    require(fseeko(file_.get(), static_cast<off_t>(place), SEEK_SET) == 0);
  }

  void close() {
    require(failure_.empty());
    require(std::fclose(file_.release()) == 0);
  }

 private:
  /// The first failure is kept: OpenEXR's destructors swallow what is thrown there.
  void require(bool done) {
    if (!done && failure_.empty()) failure_ = std::strerror(errno);
    if (!done) throw std::runtime_error(failure_);
  }

  std::unique_ptr<std::FILE, int (*)(std::FILE*)> file_;
  std::string failure_;
};

}  // namespace

void write_exr_file(const std::filesystem::path& temporary, const std::filesystem::path& path,
                    const std::function<void(Imf::OStream&)>& write) {
  try {
    OutputStream stream(temporary.string(), path.string());
    write(stream);
    stream.close();
  } catch (const std::exception& error) {
    fail_to_write(path, error.what());
  }
}

}  // namespace ld

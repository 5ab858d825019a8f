#include "sequence/movie_file.h"

#include <fcntl.h>
#include <spawn.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <memory>
#include <sstream>
#include <string>

#include "core/error.h"
#include "core/file_identity.h"
#include "core/file_io.h"
#include "core/log.h"
#include "core/tone_map.h"
#include "frame/frame_file.h"
#include "frame/picture_formats.h"

namespace ld {
namespace fs = std::filesystem;
namespace {

/// The first executable file `ffmpeg` in the folders of PATH; empty: none.
fs::path find_ffmpeg() {
  const char* const path = std::getenv("PATH");
  std::istringstream folders(path == nullptr ? "" : path);
  for (std::string folder; std::getline(folders, folder, ':');) {
    const fs::path file = fs::path(folder.empty() ? "." : folder) / "ffmpeg";
    std::error_code error;
    if (fs::is_regular_file(file, error) && access(file.c_str(), X_OK) == 0) return file;
  }
  return {};
}

std::vector<std::string> ffmpeg_arguments(const fs::path& program, const fs::path& output, bool webm,
                                          int width, int height, double frames_a_second) {
  std::vector<std::string> arguments = {
      program.string(), "-loglevel", "error", "-nostdin", "-y", "-f", "rawvideo", "-pix_fmt", "rgb24", "-s",
      fmt::format("{}x{}", width, height), "-r", fmt::format("{}", frames_a_second), "-i", "pipe:0",
      // 4:2:0 needs even sizes. Colours as HDTV's matrix has them, and said so: players guess otherwise.
      "-vf", "pad=ceil(iw/2)*2:ceil(ih/2)*2,scale=out_color_matrix=bt709:out_range=tv", "-pix_fmt", "yuv420p",
      "-colorspace", "bt709", "-color_primaries", "bt709", "-color_trc", "iec61966-2-1"};
  const std::vector<std::string> codec =
      webm
          ? std::vector<std::string>{"-c:v", "libvpx-vp9", "-crf", "18", "-b:v", "0", "-f", "webm"}
          : std::vector<std::string>{"-c:v", "libx264", "-crf", "14", "-movflags", "+faststart", "-f", "mp4"};
  arguments.insert(arguments.end(), codec.begin(), codec.end());
  arguments.push_back(output.string());
  return arguments;
}

/// A program that reads what is sent to it. A socket instead of a pipe: one that died is an error to look at,
/// not a signal that ends this program, too.
class Listener {
 public:
  explicit Listener(const std::vector<std::string>& arguments) : complaints_(std::tmpfile(), &std::fclose) {
    std::array<int, 2> ends{};
    if (!complaints_ || socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends.data()) != 0)
      fail("cannot start {}: {}", arguments[0], std::strerror(errno));
    descriptor_ = ends[0];
    std::vector<char*> words;
    for (const std::string& argument : arguments) words.push_back(const_cast<char*>(argument.c_str()));
    words.push_back(nullptr);
    posix_spawn_file_actions_t actions;
    posix_spawn_file_actions_init(&actions);
    posix_spawn_file_actions_adddup2(&actions, ends[1], STDIN_FILENO);
    posix_spawn_file_actions_addopen(&actions, STDOUT_FILENO, "/dev/null", O_WRONLY, 0);
    posix_spawn_file_actions_adddup2(&actions, fileno(complaints_.get()), STDERR_FILENO);
    posix_spawnattr_t attributes;
    posix_spawnattr_init(&attributes);
    // A process group of its own: an interrupt from the keyboard is ours to handle.
    posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETPGROUP);
    const int code = posix_spawn(&process_, words[0], &actions, &attributes, words.data(), environ);
    posix_spawnattr_destroy(&attributes);
    posix_spawn_file_actions_destroy(&actions);
    close(ends[1]);
    if (code != 0) {
      close(descriptor_);
      fail("cannot start {}: {}", arguments[0], std::strerror(code));
    }
  }
  Listener(const Listener&) = delete;
  Listener& operator=(const Listener&) = delete;
  ~Listener() {
    if (process_ > 0) end();
  }

  /// False when the program has ended.
  bool send_all(const std::vector<uint8_t>& bytes) const {
    for (size_t sent = 0; sent < bytes.size();) {
      const ssize_t count = send(descriptor_, bytes.data() + sent, bytes.size() - sent, MSG_NOSIGNAL);
      if (count < 0 && errno == EINTR) continue;
      if (count < 0) return false;
      sent += static_cast<size_t>(count);
    }
    return true;
  }

  /// Its exit code, after it has read everything; -1 when a signal ended it.
  int end() {
    close(descriptor_);
    int status = 0;
    while (waitpid(process_, &status, 0) < 0 && errno == EINTR) {
    }
    process_ = 0;
    return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  }

  /// The first line of what it complained of.
  std::string complaint() const {
    std::array<char, 400> line{};
    std::rewind(complaints_.get());
    if (std::fgets(line.data(), static_cast<int>(line.size()), complaints_.get()) == nullptr)
      return "it says nothing";
    std::string text = line.data();
    while (!text.empty() && text.back() == '\n') text.pop_back();
    return text;
  }

 private:
  std::unique_ptr<std::FILE, int (*)(std::FILE*)> complaints_;
  int descriptor_ = -1;
  pid_t process_ = 0;
};

void check_size(const Image& picture, const Image& first, size_t number) {
  if (picture.width != first.width || picture.height != first.height)
    fail("picture {} of the film is {}x{}, the first one {}x{}; expected one size", number, picture.width,
         picture.height, first.width, first.height);
}

/// Rows from the top, 8 bits of red, green and blue.
std::vector<uint8_t> shown_bytes(const Image& image) {
  std::vector<uint8_t> bytes(3 * image.plane_size());
  for (size_t c = 0; c < 3; ++c) {
    const float* const plane = image.plane(image.channels < 3 ? 0 : static_cast<int>(c));
    for (size_t p = 0; p < image.plane_size(); ++p)
      bytes[3 * p + c] = static_cast<uint8_t>(std::lround(255 * std::min(tone_map(plane[p]), 1.0F)));
  }
  return bytes;
}

/// As PNG files, which any program makes a film of.
fs::path write_pictures(const fs::path& folder, const Image& first, size_t count,
                        const std::function<Image(size_t)>& picture) {
  for (size_t i = 0; i < count; ++i) {
    const Image image = i == 0 ? first : picture(i);
    check_size(image, first, i);
    write_image(folder / fmt::format("{:06}.png", i), image);
  }
  return folder;
}

}  // namespace

Image read_shown_picture(const fs::path& path) {
  if (picture_format(path) == PictureFormat::exr) return read_image(path);
  const DecodedPicture decoded = picture_formats().read(path, 1 << 16);
  Image image(decoded.width, decoded.height, 3);
  const auto channels = static_cast<size_t>(decoded.channels);
  for (size_t c = 0; c < 3; ++c)
    for (size_t p = 0; p < image.plane_size(); ++p)
      image.plane(static_cast<int>(c))[p] =
          std::expm1(srgb_inverse(decoded.pixels[p * channels + (channels < 3 ? 0 : c)]));
  return image;
}

void require_movie_name(const std::string& option, const fs::path& path) {
  const std::string extension = lower_extension(path);
  if (extension != ".mp4" && extension != ".webm")
    fail_usage("{} {}: the extension '{}'; expected .mp4 or .webm", option, path.string(),
               path.extension().string());
}

fs::path write_movie(const fs::path& path, double frames_a_second, size_t count,
                     const std::function<Image(size_t)>& picture) {
  require_movie_name("film", path);
  if (count == 0) fail("{}: a film of no pictures", path.string());
  const Image first = picture(0);
  const fs::path ffmpeg = find_ffmpeg();
  if (ffmpeg.empty()) {
    const fs::path folder = fs::path(path).replace_extension();
    spdlog::warn("{}: no program ffmpeg in PATH, so the pictures of the film go to {}/", path.string(),
                 folder.string());
    return write_pictures(folder, first, count, picture);
  }
  write_atomically(path, [&](const fs::path& temporary) {
    Listener listener(ffmpeg_arguments(ffmpeg, temporary, lower_extension(path) == ".webm", first.width,
                                       first.height, frames_a_second));
    bool heard = listener.send_all(shown_bytes(first));
    for (size_t i = 1; heard && i < count; ++i) {
      const Image image = picture(i);
      check_size(image, first, i);
      heard = listener.send_all(shown_bytes(image));
    }
    const int code = listener.end();
    if (code != 0 || !heard)
      fail("cannot write {}: {} ended with code {}: {}", path.string(), ffmpeg.string(), code,
           listener.complaint());
  });
  return path;
}

}  // namespace ld

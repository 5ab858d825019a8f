#include "weights/checkpoint_files.h"

#include "core/checksum.h"
#include "core/error.h"
#include "core/file_io.h"
#include "core/json_text.h"

namespace ld {
namespace fs = std::filesystem;

void write_checkpoint_checksums(const fs::path& folder) {
  nlohmann::ordered_json sums;
  for (const char* name : kCheckpointFiles) sums["files"][name] = file_checksum(folder / name);
  write_file_atomically(folder / "checksums.json", sums.dump(2) + "\n");
}

void verify_checkpoint_file(const fs::path& folder, const std::string& name) {
  const fs::path path = folder / "checksums.json";
  const nlohmann::json sums = parse_json(read_file(path, 1 << 20), path.string());
  if (!sums.is_object() || !sums.contains("files") || !sums.at("files").is_object())
    fail("{}: expected {{\"files\": {{name: checksum}}}}; the checkpoint is damaged", path.string());
  const auto entry = sums.at("files").find(name);
  if (entry == sums.at("files").end() || !entry->is_string())
    fail("{}: has no checksum of {}; the checkpoint is damaged", path.string(), name);
  const std::string found = file_checksum(folder / name);
  if (found != entry->get<std::string>())
    fail("{}: checksum {}; {} says {}; the file was changed or damaged", (folder / name).string(), found,
         path.filename().string(), entry->get<std::string>());
}

}  // namespace ld

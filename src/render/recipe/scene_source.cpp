#include "render/recipe/scene_source.h"

#include <list>
#include <mutex>

#include "render/file/scene_views.h"
#include "render/random/random_scene.h"
#include "render/recipe/shots.h"

namespace ld {
namespace {

/// What planning a sequence took, kept while its frames are being rendered.
template <class Plan>
class PlanCache {
 public:
  /// make() runs at most once at a time; the few last plans are kept.
  template <class Make>
  std::shared_ptr<const Plan> get(int64_t sequence, const Make& make) {
    const std::lock_guard<std::mutex> lock(mutex_);
    for (const auto& [number, plan] : plans_)
      if (number == sequence) return plan;
    plans_.emplace_front(sequence, std::make_shared<const Plan>(make()));
    if (plans_.size() > kKept) plans_.pop_back();
    return plans_.front().second;
  }

 private:
  static constexpr size_t kKept = 3;
  std::mutex mutex_;
  std::list<std::pair<int64_t, std::shared_ptr<const Plan>>> plans_;
};

std::unique_ptr<PreparedScene> prepared_random(const Recipe& recipe, int64_t number) {
  return prepare_random_scene(recipe.scenes, recipe.seed, static_cast<uint32_t>(number), recipe.width(),
                              recipe.height());
}

class RandomScenes : public SceneSource {
 public:
  explicit RandomScenes(const Recipe& recipe) : recipe_(recipe) {}
  std::unique_ptr<PreparedScene> prepare(int64_t frame) const override {
    return prepared_random(recipe_, frame);
  }

 private:
  Recipe recipe_;
};

class RandomSequences : public SceneSource {
 public:
  explicit RandomSequences(const Recipe& recipe) : recipe_(recipe) {}

  std::unique_ptr<PreparedScene> prepare(int64_t frame) const override {
    const int64_t sequence = recipe_.sequence_of(frame);
    const auto shot = shots_.get(sequence, [&] { return plan_shot(recipe_, sequence); });
    return std::make_unique<PreparedScene>(
        shot_frame(*shot, recipe_.position_of(frame), static_cast<float>(recipe_.sequence.shutter)));
  }

 private:
  Recipe recipe_;
  mutable PlanCache<Shot> shots_;
};

/// A scene file, loaded once.
class SceneFileFrames : public SceneSource {
 public:
  explicit SceneFileFrames(const Recipe& recipe) : recipe_(recipe), file_(config_.path, config_.animation) {
    if (!config_.probe.empty()) {
      const auto turn = static_cast<float>(config_.probe_turn) * kPi / 180;
      probe_ = read_probe(config_.probe, grey(static_cast<float>(config_.probe_scale)), turn);
    }
    look_ = std::make_unique<PreparedScene>(furnished({config_.time, config_.time, config_.time}));
    exposure_ = static_cast<float>(config_.exposure);
    if (exposure_ == 0) exposure_ = automatic_exposure(*look_, view(0).camera, recipe_.seed);
  }

  std::unique_ptr<PreparedScene> prepare(int64_t frame) const override {
    const SceneView chosen = view(frame);
    return finished(furnished(chosen.times), chosen.camera, chosen.name);
  }

 protected:
  SceneView view(int64_t number) const {
    return choose_view(file_, config_, *look_, recipe_.seed, static_cast<uint32_t>(number), recipe_.width(),
                       recipe_.height());
  }
  Scene furnished(const FrameTimes& times) const {
    Scene scene = file_.scene(times);
    furnish(scene, file_, config_, probe_);
    return scene;
  }
  std::unique_ptr<PreparedScene> finished(Scene scene, const Camera& camera, const std::string& name) const {
    scene.camera = camera;
    scene.name += ", " + name;
    auto prepared = std::make_unique<PreparedScene>(std::move(scene));
    if (exposure_ != 1) prepared->scale_lights(exposure_);
    return prepared;
  }

  Recipe recipe_;
  const SceneFileConfig& config_ = recipe_.scene_file;
  SceneFile file_;
  std::optional<Probe> probe_;
  std::unique_ptr<const PreparedScene> look_;
  float exposure_ = 1;
};

/// The file's animation frame by frame from config.time on. A camera of the file that is animated is
/// followed; others fly.
class SceneFileSequences : public SceneFileFrames {
 public:
  using SceneFileFrames::SceneFileFrames;

  std::unique_ptr<PreparedScene> prepare(int64_t frame) const override {
    const int64_t sequence = recipe_.sequence_of(frame), position = recipe_.position_of(frame);
    const auto plan = plans_.get(sequence, [&] { return make_plan(sequence); });
    const double step = config_.frame_time * recipe_.sequence.speed;
    const double open = config_.time + static_cast<double>(position) * step;
    const FrameTimes times = {open, open + step * recipe_.sequence.shutter, open - step};
    Camera camera = plan->view.camera;
    const auto shutter = static_cast<float>(recipe_.sequence.shutter);
    if (plan->follows_file) {
      camera = file_.camera(static_cast<size_t>(plan->view.file_camera), times);
      camera.width = recipe_.width();
      camera.height = recipe_.height();
    } else {
      camera = fly(camera, plan->path, position, shutter);
    }
    return finished(furnished(times), camera, plan->view.name);
  }

 private:
  struct Plan {
    SceneView view;
    bool follows_file;
    CameraPath path;
  };

  Plan make_plan(int64_t sequence) const {
    SceneView start = view(sequence);
    RandomStream random(recipe_.seed, RandomPurpose::scene, static_cast<uint32_t>(sequence), 0, kPathStream);
    CameraPath path = plan_camera_path(*look_, start.camera.at(0), start.distance, recipe_.sequence.length,
                                       static_cast<float>(recipe_.sequence.speed), random);
    const bool follows = start.file_camera >= 0 && file_.camera_moves(static_cast<size_t>(start.file_camera));
    return {std::move(start), follows, std::move(path)};
  }

  mutable PlanCache<Plan> plans_;
};

}  // namespace

std::unique_ptr<SceneSource> make_scene_source(const Recipe& recipe) {
  const bool sequences = recipe.sequence.used();
  if (recipe.scene_file.used()) {
    if (sequences) return std::make_unique<SceneFileSequences>(recipe);
    return std::make_unique<SceneFileFrames>(recipe);
  }
  if (sequences) return std::make_unique<RandomSequences>(recipe);
  return std::make_unique<RandomScenes>(recipe);
}

}  // namespace ld

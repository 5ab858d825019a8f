#include "render/file/scene_file_nodes.h"

#include <algorithm>

namespace ld {
namespace {

using Quaternion = aiQuaterniont<double>;

aiVector3t<double> column(const NodeMatrix& m, unsigned c) {
  return {m[0][c], m[1][c], m[2][c]};
}

Vec3 to_vec3(const aiVector3t<double>& v) {
  return {static_cast<float>(v.x), static_cast<float>(v.y), static_cast<float>(v.z)};
}

Quaternion rotation_of(const NodeMatrix& m) {
  aiVector3t<double> scaling, position;
  Quaternion rotation;
  m.Decompose(scaling, rotation, position);
  return rotation.Normalize();
}

}  // namespace

Vec3 transform_point(const NodeMatrix& m, Vec3 p) {
  return to_vec3(m * aiVector3t<double>(p.x, p.y, p.z));
}

Vec3 transform_vector(const NodeMatrix& m, Vec3 v) {
  return to_vec3(column(m, 0) * double{v.x} + column(m, 1) * double{v.y} + column(m, 2) * double{v.z});
}

Vec3 transform_normal(const NodeMatrix& m, Vec3 n) {
  const auto x = column(m, 0), y = column(m, 1), z = column(m, 2);
  const auto yz = y ^ z, zx = z ^ x, xy = x ^ y;  // ^ is Assimp's cross product
  const double sign = x * yz < 0 ? -1 : 1;
  return to_vec3((yz * double{n.x} + zx * double{n.y} + xy * double{n.z}) * sign);
}

Motion rigid_motion(const NodeMatrix& from, const NodeMatrix& to, Vec3 centre) {
  Motion motion;
  const aiVector3t<double> local(centre.x, centre.y, centre.z);
  const auto start = from * local;
  motion.translation = to_vec3(to * local - start);
  Quaternion back = rotation_of(from);
  Quaternion turn = rotation_of(to) * back.Conjugate();
  if (turn.w < 0) turn = {-turn.w, -turn.x, -turn.y, -turn.z};  // the shorter way round
  const double sine = std::sqrt(turn.x * turn.x + turn.y * turn.y + turn.z * turn.z);
  if (sine < 1e-7) return motion;
  motion.axis = normalize(to_vec3(aiVector3t<double>(turn.x, turn.y, turn.z) / sine));
  motion.angle = static_cast<float>(2 * std::atan2(sine, turn.w));
  motion.pivot = to_vec3(start);
  return motion;
}

NodeTree::NodeTree(const aiScene& scene, size_t animation) {
  add(*scene.mRootNode, -1);
  if (animation < scene.mNumAnimations) read_tracks(*scene.mAnimations[animation]);
}

void NodeTree::add(const aiNode& node, int parent) {
  const auto index = static_cast<int>(nodes_.size());
  Node own;
  own.name = node.mName.C_Str();
  own.parent = parent;
  own.local = NodeMatrix(node.mTransformation);
  own.meshes.assign(node.mMeshes, node.mMeshes + node.mNumMeshes);
  by_name_.emplace(own.name, index);
  nodes_.push_back(std::move(own));
  for (unsigned i = 0; i < node.mNumChildren; ++i) add(*node.mChildren[i], index);
}

void NodeTree::read_tracks(const aiAnimation& animation) {
  const double ticks = animation.mTicksPerSecond > 0 ? animation.mTicksPerSecond : 25;  // Assimp's advice
  for (unsigned c = 0; c < animation.mNumChannels; ++c) {
    const aiNodeAnim& channel = *animation.mChannels[c];
    const int node = find(channel.mNodeName.C_Str());
    if (node < 0) continue;
    Track track;
    const auto vectors = [&](const aiVectorKey* keys, unsigned count) {
      std::vector<Key> result;
      for (unsigned i = 0; i < count; ++i)
        result.push_back({keys[i].mTime / ticks, {keys[i].mValue.x, keys[i].mValue.y, keys[i].mValue.z, 0}});
      return result;
    };
    track.position = vectors(channel.mPositionKeys, channel.mNumPositionKeys);
    track.scaling = vectors(channel.mScalingKeys, channel.mNumScalingKeys);
    for (unsigned i = 0; i < channel.mNumRotationKeys; ++i) {
      const aiQuaternion& q = channel.mRotationKeys[i].mValue;
      track.rotation.push_back({channel.mRotationKeys[i].mTime / ticks, {q.w, q.x, q.y, q.z}});
    }
    for (const auto* keys : {&track.position, &track.rotation, &track.scaling})
      if (!keys->empty()) duration_ = std::max(duration_, keys->back().time);
    nodes_[static_cast<size_t>(node)].track = static_cast<int>(tracks_.size());
    tracks_.push_back(std::move(track));
  }
}

int NodeTree::find(const std::string& name) const {
  const auto it = by_name_.find(name);
  return it == by_name_.end() ? -1 : it->second;
}

std::array<double, 4> NodeTree::value_at(const std::vector<Key>& keys, double time, bool quaternion) {
  const auto next =
      std::upper_bound(keys.begin(), keys.end(), time, [](double t, const Key& key) { return t < key.time; });
  if (next == keys.begin()) return keys.front().value;
  const Key& a = *(next - 1);
  if (next == keys.end()) return a.value;
  const double t = (time - a.time) / (next->time - a.time);
  std::array<double, 4> result{};
  if (!quaternion) {
    for (size_t i = 0; i < 4; ++i) result[i] = a.value[i] + t * (next->value[i] - a.value[i]);
    return result;
  }
  const auto& p = a.value;
  const auto& q = next->value;
  Quaternion between;
  Quaternion::Interpolate(between, {p[0], p[1], p[2], p[3]}, {q[0], q[1], q[2], q[3]}, t);
  return {between.w, between.x, between.y, between.z};
}

NodeMatrix NodeTree::local_at(const Node& node, double seconds) const {
  if (node.track < 0) return node.local;
  const Track& track = tracks_[static_cast<size_t>(node.track)];
  aiVector3t<double> scaling, position;
  Quaternion rotation;
  node.local.Decompose(scaling, rotation, position);
  if (!track.position.empty()) {
    const auto v = value_at(track.position, seconds, false);
    position = {v[0], v[1], v[2]};
  }
  if (!track.scaling.empty()) {
    const auto v = value_at(track.scaling, seconds, false);
    scaling = {v[0], v[1], v[2]};
  }
  if (!track.rotation.empty()) {
    const auto v = value_at(track.rotation, seconds, true);
    rotation = Quaternion(v[0], v[1], v[2], v[3]).Normalize();
  }
  return {scaling, rotation, position};
}

std::vector<NodeMatrix> NodeTree::world(double seconds) const {
  std::vector<NodeMatrix> matrices;
  matrices.reserve(nodes_.size());
  for (const Node& node : nodes_) {
    const NodeMatrix local = local_at(node, seconds);
    matrices.push_back(node.parent < 0 ? local : matrices[static_cast<size_t>(node.parent)] * local);
  }
  return matrices;
}

}  // namespace ld

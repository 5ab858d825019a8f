// The tree of nodes of a file that Assimp read, with its animation. Inside the library only: pulls Assimp in.
#pragma once

#include <assimp/scene.h>

#include <array>
#include <map>
#include <string>
#include <vector>

#include "render/geometry/camera.h"
#include "render/geometry/motion.h"

namespace ld {

/// Double precision: the motion over a shutter of a hundredth of a second is a small difference.
using NodeMatrix = aiMatrix4x4t<double>;

Vec3 transform_point(const NodeMatrix& m, Vec3 p);
Vec3 transform_vector(const NodeMatrix& m, Vec3 v);
/// Not normalised; by the cofactors, so that scaled and mirrored surfaces keep their normals.
Vec3 transform_normal(const NodeMatrix& m, Vec3 n);

/// The rigid part of the way from one world matrix of a node to another: its turn, and the move of the point
/// that `centre` (local) is. Growing and shearing are left out.
Motion rigid_motion(const NodeMatrix& from, const NodeMatrix& to, Vec3 centre);

class NodeTree {
 public:
  struct Node {
    std::string name;
    int parent = -1;  // parents come before their children
    NodeMatrix local;
    int track = -1;
    std::vector<unsigned> meshes;
  };

  /// `animation` is an index into the file's; none is used where the file has fewer.
  NodeTree(const aiScene& scene, size_t animation);

  const std::vector<Node>& nodes() const { return nodes_; }
  /// -1 when there is none.
  int find(const std::string& name) const;
  /// Of the animation, seconds; 0 without one.
  double duration() const { return duration_; }
  /// World matrices of all nodes. Before its first and after its last key an animated node stands still.
  std::vector<NodeMatrix> world(double seconds) const;

 private:
  struct Key {
    double time;
    std::array<double, 4> value;  // x, y, z or a quaternion's w, x, y, z
  };
  struct Track {
    std::vector<Key> position, rotation, scaling;
  };

  void add(const aiNode& node, int parent);
  void read_tracks(const aiAnimation& animation);
  static std::array<double, 4> value_at(const std::vector<Key>& keys, double time, bool quaternion);
  NodeMatrix local_at(const Node& node, double seconds) const;

  std::vector<Node> nodes_;
  std::map<std::string, int> by_name_;
  std::vector<Track> tracks_;
  double duration_ = 0;
};

}  // namespace ld

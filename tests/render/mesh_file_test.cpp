// Meshes read from the user's files.
#include "render/geometry/mesh_file.h"

#include <gtest/gtest.h>

#include "core/file_io.h"
#include "render/geometry/mesh_tools.h"
#include "tests/support/expect_error.h"
#include "tests/support/temporary_folder.h"

namespace ld {
namespace {

class MeshFile : public ::testing::Test {
 protected:
  std::filesystem::path write(const char* name, const std::string& text) {
    write_file_atomically(folder_.path() / name, text);
    return folder_.path() / name;
  }
  TemporaryFolder folder_;
};

TEST_F(MeshFile, ReadsAnObjWithTextureCoordinates) {
  const Mesh mesh = read_mesh(write("square.obj",
                                    "v 2 0 0\nv 6 0 0\nv 6 4 0\nv 2 4 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\n"
                                    "f 1/1 2/2 3/3 4/4\n"));
  EXPECT_EQ(mesh.triangles.size(), 2U) << "the quad was cut in two";
  ASSERT_EQ(mesh.uvs.size(), mesh.positions.size());
  ASSERT_EQ(mesh.normals.size(), mesh.positions.size());
  EXPECT_NEAR(radius_around(mesh.positions, {}), 1, 1e-5);
  for (size_t i = 0; i < mesh.positions.size(); ++i) {
    EXPECT_NEAR(mesh.normals[i].z, 1, 1e-5);
    EXPECT_NEAR(mesh.uvs[i].x, mesh.positions[i].x > 0 ? 1 : 0, 1e-5);
    EXPECT_NEAR(mesh.uvs[i].y, mesh.positions[i].y > 0 ? 1 : 0, 1e-5) << "v runs upwards";
  }
}

TEST_F(MeshFile, ReadsStoredNormals) {
  const Mesh mesh =
      read_mesh(write("leaning.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nvn 0 3 4\nf 1//1 2//1 3//1\n"));
  ASSERT_EQ(mesh.normals.size(), 3U);
  EXPECT_NEAR(mesh.normals[0].y, 0.6, 1e-5);
  EXPECT_NEAR(mesh.normals[0].z, 0.8, 1e-5);
}

TEST_F(MeshFile, NamesWhatIsWrong) {
  EXPECT_ERROR(read_mesh(folder_.path() / "none.obj"), "none.obj: no such file");
  EXPECT_ERROR(read_mesh(write("text.ply", "this is not a mesh")), "text.ply");
  EXPECT_ERROR(read_mesh(write("points.obj", "v 0 0 0\nv 1 0 0\n")), "points.obj");
}

}  // namespace
}  // namespace ld

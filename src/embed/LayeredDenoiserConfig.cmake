# find_package(LayeredDenoiser) gives the target LayeredDenoiser::layered_denoiser.
include(${CMAKE_CURRENT_LIST_DIR}/LayeredDenoiserTargets.cmake)

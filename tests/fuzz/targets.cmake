# Every fuzz target, listed once for the build (fuzz/CMakeLists.txt) and for the suite (../CMakeLists.txt):
#
#   nlg_fuzz_target(NAME RUNS in the suite OPTIONS of libFuzzer … SOURCES beside NAME_fuzz.cpp … LINKS …)
nlg_fuzz_target(weights RUNS 20000 OPTIONS -max_len=4096 -dict=weights.dict SOURCES weights_seeds.cpp digests.cpp)
nlg_fuzz_target(light_grid RUNS 20000 OPTIONS -max_len=12000 SOURCES light_grid_seeds.cpp digests.cpp)
nlg_fuzz_target(gltf RUNS 20000 OPTIONS -max_len=4096 -dict=gltf.dict LINKS GTest::gtest)
nlg_fuzz_target(bsp RUNS 20000 OPTIONS -max_len=8192)
nlg_fuzz_target(pk3 RUNS 10000 OPTIONS -max_len=8192 SOURCES zip_file.cpp)
nlg_fuzz_target(shader_script RUNS 60000 OPTIONS -max_len=2048 -dict=quake.dict)
nlg_fuzz_target(entities RUNS 60000 OPTIONS -max_len=2048 -dict=quake.dict)
nlg_fuzz_target(texture RUNS 60000 OPTIONS -max_len=1024)
nlg_fuzz_target(options RUNS 20000 OPTIONS -max_len=1024 -dict=yaml.dict)
nlg_fuzz_target(shard RUNS 1000 OPTIONS -max_len=512 -detect_leaks=0 SOURCES hdf5_recipe.cpp)
nlg_fuzz_target(basis RUNS 500 OPTIONS -max_len=512 -detect_leaks=0 SOURCES hdf5_recipe.cpp)
nlg_fuzz_target(cache RUNS 20000 OPTIONS -max_len=1024 -dict=cache.dict)
nlg_fuzz_target(checkpoint RUNS 1000 OPTIONS -max_len=32768 -detect_leaks=0 LINKS nlg::torch
  SOURCES ${PROJECT_SOURCE_DIR}/train/generator/checkpoint.cpp ${PROJECT_SOURCE_DIR}/train/generator/generator_network.cpp)

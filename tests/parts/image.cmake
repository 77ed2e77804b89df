if(TARGET mv_image)
  find_package(ZLIB REQUIRED)
  mv_add_test(unit_image_nifti SOURCES unit/image/nifti_test.cpp unit/image/distance_map_test.cpp LIBRARIES mv_image ZLIB::ZLIB)
  mv_add_test(unit_image_labels SOURCES unit/image/label_surface_test.cpp unit/image/label_landmarks_test.cpp unit/image/broken_labels_test.cpp
    LIBRARIES mv_image ZLIB::ZLIB)
endif()

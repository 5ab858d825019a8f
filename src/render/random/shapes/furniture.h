// Compound models of rooms and streets, in about metres before they are fitted to unit radius.
#pragma once

#include "render/random/shapes/model.h"

namespace ld {

// furniture.cpp
Model make_table(RandomStream& random);
Model make_chair(RandomStream& random);
Model make_stool(RandomStream& random);
Model make_sofa(RandomStream& random);
Model make_bed(RandomStream& random);
Model make_cabinet(RandomStream& random);
Model make_bookshelf(RandomStream& random);
Model make_stairs(RandomStream& random);
Model make_spiral_stairs(RandomStream& random);

// fixtures.cpp
Model make_floor_lamp(RandomStream& random);
Model make_desk_lamp(RandomStream& random);
Model make_chandelier(RandomStream& random);
Model make_window_blinds(RandomStream& random);
Model make_picture(RandomStream& random);
Model make_monitor(RandomStream& random);
Model make_radiator(RandomStream& random);
Model make_candles(RandomStream& random);
Model make_pipes(RandomStream& random);
Model make_wheel(RandomStream& random);
Model make_umbrella(RandomStream& random);

// vessels.cpp
Model make_vase(RandomStream& random);
Model make_bottle(RandomStream& random);
Model make_goblet(RandomStream& random);
Model make_bowl(RandomStream& random);
Model make_jug(RandomStream& random);
Model make_column(RandomStream& random);
Model make_pawn(RandomStream& random);
Model make_plate_stack(RandomStream& random);
Model make_box_stack(RandomStream& random);
Model make_book_stack(RandomStream& random);
Model make_coin_stack(RandomStream& random);
Model make_crate(RandomStream& random);
Model make_barrel(RandomStream& random);
Model make_fruit_bowl(RandomStream& random);

}  // namespace ld

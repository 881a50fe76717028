"""Real winches on CANopen or EtherCAT drives: their bus, their states, and the machine made of them."""

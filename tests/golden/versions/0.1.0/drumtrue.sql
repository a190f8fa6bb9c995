BEGIN TRANSACTION;
CREATE TABLE alembic_version (
	version_num VARCHAR(32) NOT NULL, 
	CONSTRAINT alembic_version_pkc PRIMARY KEY (version_num)
);
INSERT INTO "alembic_version" VALUES('0010');
CREATE TABLE audit (
	id INTEGER NOT NULL, 
	number BIGINT, 
	at DATETIME NOT NULL, 
	actor VARCHAR(100) NOT NULL, 
	action VARCHAR(16) NOT NULL, 
	kind VARCHAR(32) NOT NULL, 
	"key" VARCHAR(100) NOT NULL, 
	session_id VARCHAR(32), 
	changes TEXT NOT NULL, 
	hash VARCHAR(64), 
	CONSTRAINT pk_audit PRIMARY KEY (id), 
	CONSTRAINT uq_audit_number UNIQUE (number)
);
INSERT INTO "audit" VALUES(1,1,'2026-11-28 12:17:54.808675','local','added','machine','19509a0001c54d398e86978768ef1c43',NULL,'{"name":"drum","created_at":"2026-11-28T12:17:54.806732+00:00","updated_at":"2026-11-28T12:17:54.806732+00:00"}','8133f0283d4d9a4c2bc507ed4ed2dbaf93378d9b9a71a2e596b84b840791a12f');
INSERT INTO "audit" VALUES(2,2,'2026-11-28 12:17:54.828694','local','added','catalogue','fc224d3023ae4da4a19f8302801bb154',NULL,'{"name":"box","created_at":"2026-11-28T12:17:54.821037+00:00"}','ff0838d63f4d117f8e0c9a11239a26d884b0ba775e2e2bf0463454cce3bfea43');
INSERT INTO "audit" VALUES(3,3,'2026-11-28 12:17:54.828694','local','received','catalogue','fc224d3023ae4da4a19f8302801bb154',NULL,'{"movements":[{"item":0,"pieces":10,"held":0},{"item":1,"pieces":10,"held":0},{"item":2,"pieces":10,"held":0},{"item":3,"pieces":10,"held":0},{"item":4,"pieces":10,"held":0},{"item":5,"pieces":10,"held":0}]}','4d0db8c4ed20734686f5d679e6bc4bd068ac3bfb38b3be9b49e3c827d745d10b');
INSERT INTO "audit" VALUES(4,4,'2026-11-28 12:17:54.838989','local','added','source','bridge',NULL,'{"name":"bridge","machine_id":"19509a0001c54d398e86978768ef1c43","bound_at":"2026-11-28T12:17:54.837897+00:00"}','59586e56bdf54910e5177016d7ff3def214c96fc9ec03b628dc82fc28f37a74c');
INSERT INTO "audit" VALUES(5,5,'2026-11-28 12:17:54.844592','local','added','source','balancer',NULL,'{"name":"balancer","machine_id":"19509a0001c54d398e86978768ef1c43","bound_at":"2026-11-28T12:17:54.844159+00:00"}','8701610d451f108ccc6d7d3b116f74596e826980173c8809640d30fe3b3aa49d');
INSERT INTO "audit" VALUES(6,6,'2026-11-28 12:17:54.860534','local','added','session','126046a2232e4313a381263690aa0a5c','126046a2232e4313a381263690aa0a5c','{"machine_id":"19509a0001c54d398e86978768ef1c43","machine_name":"drum","catalogue_id":"fc224d3023ae4da4a19f8302801bb154","state":"open","note":"for later","created_at":"2026-11-28T12:17:54.853450+00:00"}','bfc5b97c4dfd3f6c9e60df34e0bf488198f362cdb0bf2b95158b5363f0661824');
INSERT INTO "audit" VALUES(7,7,'2026-11-28 12:17:54.870743','local','added','run','b7a47ec099684045970727bdb064b417','126046a2232e4313a381263690aa0a5c','{"session_id":"126046a2232e4313a381263690aa0a5c","number":1}','7a7a653b38684e5700d8436b1c99d19d3f765978b9c940e828fbcbf7e7124137');
INSERT INTO "audit" VALUES(8,8,'2026-11-28 12:17:54.877382','local','added','run','fe5e163a627e4a4d8e32d84a4b889e6e','126046a2232e4313a381263690aa0a5c','{"session_id":"126046a2232e4313a381263690aa0a5c","number":2}','3613c39d6df36da3fcc15d45486f009888c0b5a5982cdeecfccf7ae293dd1348');
INSERT INTO "audit" VALUES(9,9,'2026-11-28 12:17:54.885000','local','added','run','05b2ab05d47b417d86eac1fe8b46a323','126046a2232e4313a381263690aa0a5c','{"session_id":"126046a2232e4313a381263690aa0a5c","number":3}','a08c8f6ff38c2943fcbd6c22b8b2c1f5f418543684aeff27a290cc220407b184');
INSERT INTO "audit" VALUES(10,10,'2026-11-28 12:17:54.895669','local','added','correction','aeb2f3a066b64d1082cb91f144fb18dd','126046a2232e4313a381263690aa0a5c','{"session_id":"126046a2232e4313a381263690aa0a5c","number":1}','207a359846933a3edf2c2a9a8cc0912e0d2eac3ef8c745a949e8f24c89044764');
INSERT INTO "audit" VALUES(11,11,'2026-11-28 12:17:54.895669','local','changed','session','126046a2232e4313a381263690aa0a5c','126046a2232e4313a381263690aa0a5c','{"state":["open","corrected"]}','d1ce2bf67e6f6665eabdcd43f5da07052663e4af6e57df703fd4b86337b8cd90');
INSERT INTO "audit" VALUES(12,12,'2026-11-28 12:17:54.911147','local','added','plan','c1de695b1a0c4bbdbb3bdb12922b00de','126046a2232e4313a381263690aa0a5c','{"session_id":"126046a2232e4313a381263690aa0a5c","number":1}','10422c5327f96de88d7f50326bfca4233a24317d355947fa29d9e527d6d6200a');
INSERT INTO "audit" VALUES(13,13,'2026-11-28 12:17:54.911147','local','changed','session','126046a2232e4313a381263690aa0a5c','126046a2232e4313a381263690aa0a5c','{"state":["corrected","planned"]}','88ca03cad4c6af054f9025a0d4f1a2d34029d8c2c891583f9b70c93c40239b42');
INSERT INTO "audit" VALUES(14,14,'2026-11-28 12:17:54.928146','local','fitted','catalogue','fc224d3023ae4da4a19f8302801bb154','126046a2232e4313a381263690aa0a5c','{"movements":[{"item":3,"pieces":-1,"held":0,"plan_id":"c1de695b1a0c4bbdbb3bdb12922b00de"},{"item":4,"pieces":-2,"held":0,"plan_id":"c1de695b1a0c4bbdbb3bdb12922b00de"},{"item":5,"pieces":-1,"held":0,"plan_id":"c1de695b1a0c4bbdbb3bdb12922b00de"}]}','3e77665bcf01ce8c9a6466c60aefd6d1185af363f83d132267892abca6160b37');
INSERT INTO "audit" VALUES(15,15,'2026-11-28 12:17:54.928146','local','changed','session','126046a2232e4313a381263690aa0a5c','126046a2232e4313a381263690aa0a5c','{"state":["planned","fitted"],"fitted_plan_id":[null,"c1de695b1a0c4bbdbb3bdb12922b00de"]}','2499d7c9ad5608c436ab2429b713d031c842244f743bfbca00f8150fa375bf28');
INSERT INTO "audit" VALUES(16,16,'2026-11-28 12:17:54.928146','local','changed','plan','c1de695b1a0c4bbdbb3bdb12922b00de','126046a2232e4313a381263690aa0a5c','{"plan.state":["proposed","fitted"],"plan.fitted":[null,[{"plane":"1","position_deg":160.0,"hole":"8","mass_g":100.0,"fastener_g":0.0,"weighed_g":null,"from_box":true},{"plane":"1","position_deg":200.0,"hole":"10","mass_g":200.0,"fastener_g":0.0,"weighed_g":null,"from_box":true},{"plane":"2","position_deg":240.0,"hole":"12","mass_g":300.0,"fastener_g":0.0,"weighed_g":null,"from_box":true},{"plane":"2","position_deg":340.0,"hole":"17","mass_g":200.0,"fastener_g":0.0,"weighed_g":null,"from_box":true}]]}','276636a7a813abebd06dfd9f8308af430dab836a3057457dceaa27f57cfa7d9e');
INSERT INTO "audit" VALUES(17,17,'2026-11-28 12:17:54.935765','local','added','run','f3dce9bf66f44630946828a992e7ff18','126046a2232e4313a381263690aa0a5c','{"session_id":"126046a2232e4313a381263690aa0a5c","number":4}','23ff0cf61dad3a3a91115f4660de863c4e0beb424f774a420840b72bc31cc125');
INSERT INTO "audit" VALUES(18,18,'2026-11-28 12:17:54.935765','local','changed','correction','aeb2f3a066b64d1082cb91f144fb18dd','126046a2232e4313a381263690aa0a5c','{"correction.stale":[false,true]}','da199b9cf32eb06c5f444593d8da76ba198ec51efebc6a23538113e3a2de9ffd');
INSERT INTO "audit" VALUES(19,19,'2026-11-28 12:17:54.935765','local','changed','session','126046a2232e4313a381263690aa0a5c','126046a2232e4313a381263690aa0a5c','{"state":["fitted","checked"]}','ee6f7366aa951cf1e45f09669d610e883a6375aba28b5ebebe22f27a4f36a498');
INSERT INTO "audit" VALUES(20,20,'2026-11-28 12:17:54.944829','local','added','influence','0dc6a8fa31ff46518396e93123960904','126046a2232e4313a381263690aa0a5c','{"machine_id":"19509a0001c54d398e86978768ef1c43","session_id":"126046a2232e4313a381263690aa0a5c","machine_type":"T1","learned_at":"2026-11-28T12:17:54.943455+00:00"}','42cccf830bf3d18e1799464e0c48b7eae7e724ab57b5d3de3bbfa450f503fe24');
INSERT INTO "audit" VALUES(21,21,'2026-11-28 12:17:54.962366','local','changed','session','126046a2232e4313a381263690aa0a5c','126046a2232e4313a381263690aa0a5c','{"state":["checked","closed"],"closed_at":[null,"2026-11-28T12:17:54.948785+00:00"]}','2f705fa7086fda24d8783c10801a2ede71be4324584704beb1152d765c9bf461');
INSERT INTO "audit" VALUES(22,22,'2026-11-28 12:17:54.962366','local','closed','session','126046a2232e4313a381263690aa0a5c','126046a2232e4313a381263690aa0a5c','{"record_sha256":"e3258f5bce0c04a72038af6bef5439ab4d59fe777725b5dd98205976eb3b5eee","format":1}','f95e32cf2d84f8e766211903ba29eda6e080f0715776944fa55b0329ba72b9ad');
INSERT INTO "audit" VALUES(23,23,'2026-11-28 12:17:54.984915','local','added','session','245e96a653a44bb290b1d376e645dd4a','245e96a653a44bb290b1d376e645dd4a','{"machine_id":"19509a0001c54d398e86978768ef1c43","machine_name":"drum","catalogue_id":"fc224d3023ae4da4a19f8302801bb154","state":"open","note":"for later","created_at":"2026-11-28T12:17:54.979167+00:00"}','5a1daf040ee336b1f36e4db24ce47f022d487b911e4bf533a34b259f4bbef036');
INSERT INTO "audit" VALUES(24,24,'2026-11-28 12:17:54.996908','local','added','run','dfdefcf733374553a0ba0ba14852211e','245e96a653a44bb290b1d376e645dd4a','{"session_id":"245e96a653a44bb290b1d376e645dd4a","number":1}','674f322142051738b36f74fe339d08af21426a8eeaec48d3cacf3f9f3fa59944');
INSERT INTO "audit" VALUES(25,25,'2026-11-28 12:17:55.003983','local','added','run','e88fd431aae94024b595967b842d40a6','245e96a653a44bb290b1d376e645dd4a','{"session_id":"245e96a653a44bb290b1d376e645dd4a","number":2}','8f2c664b6d196f6372d0bb2136d5621273061014e5483aeb0e3cd040ae147677');
INSERT INTO "audit" VALUES(26,26,'2026-11-28 12:17:55.009251','local','added','run','0edd7d4654a4417d99ceed125cd0e6f5','245e96a653a44bb290b1d376e645dd4a','{"session_id":"245e96a653a44bb290b1d376e645dd4a","number":3}','614a172820955b29980d3b0860efb8dfa1327798f3692c4f747b180c3be857c7');
INSERT INTO "audit" VALUES(27,27,'2026-11-28 12:17:55.016616','local','added','correction','5a0b770d01f64c479797a0a342bd0ff1','245e96a653a44bb290b1d376e645dd4a','{"session_id":"245e96a653a44bb290b1d376e645dd4a","number":1}','8a807167b38c81612f0d954188e3bae9d4cbee2c4441320085afa1d00491aaaa');
INSERT INTO "audit" VALUES(28,28,'2026-11-28 12:17:55.016616','local','changed','session','245e96a653a44bb290b1d376e645dd4a','245e96a653a44bb290b1d376e645dd4a','{"state":["open","corrected"]}','b80222b64f897c8b14edc7ba61c88843b75365d083f28128f083a11bfff6bab3');
INSERT INTO "audit" VALUES(29,29,'2026-11-28 12:17:55.029464','local','added','plan','49ab8648f46c41c19fd498a90bd0ec43','245e96a653a44bb290b1d376e645dd4a','{"session_id":"245e96a653a44bb290b1d376e645dd4a","number":1}','414d095ea1ecd58d1e924e224e1f0a014d6875d53fd4a5ce29a2dee63ef3e983');
INSERT INTO "audit" VALUES(30,30,'2026-11-28 12:17:55.029464','local','changed','session','245e96a653a44bb290b1d376e645dd4a','245e96a653a44bb290b1d376e645dd4a','{"state":["corrected","planned"]}','4540b863d8f2e1e41b82a785b9daf6381de085e24d0b33a39f416bb808d52f0f');
INSERT INTO "audit" VALUES(31,31,'2026-11-28 12:17:55.049103','local','fitted','catalogue','fc224d3023ae4da4a19f8302801bb154','245e96a653a44bb290b1d376e645dd4a','{"movements":[{"item":3,"pieces":-1,"held":0,"plan_id":"49ab8648f46c41c19fd498a90bd0ec43"},{"item":4,"pieces":-2,"held":0,"plan_id":"49ab8648f46c41c19fd498a90bd0ec43"},{"item":5,"pieces":-1,"held":0,"plan_id":"49ab8648f46c41c19fd498a90bd0ec43"}]}','90cb16d2e041d639795bffbff72455405749fa2cf99240efa0684b62bc703f72');
INSERT INTO "audit" VALUES(32,32,'2026-11-28 12:17:55.049103','local','changed','session','245e96a653a44bb290b1d376e645dd4a','245e96a653a44bb290b1d376e645dd4a','{"state":["planned","fitted"],"fitted_plan_id":[null,"49ab8648f46c41c19fd498a90bd0ec43"]}','c25f81c9b3ff6be3e2d1534e89bc42e3aa8f09013d78073c2743a9e1c46de89e');
INSERT INTO "audit" VALUES(33,33,'2026-11-28 12:17:55.049103','local','changed','plan','49ab8648f46c41c19fd498a90bd0ec43','245e96a653a44bb290b1d376e645dd4a','{"plan.state":["proposed","fitted"],"plan.fitted":[null,[{"plane":"1","position_deg":160.0,"hole":"8","mass_g":100.0,"fastener_g":0.0,"weighed_g":null,"from_box":true},{"plane":"1","position_deg":200.0,"hole":"10","mass_g":200.0,"fastener_g":0.0,"weighed_g":null,"from_box":true},{"plane":"2","position_deg":240.0,"hole":"12","mass_g":300.0,"fastener_g":0.0,"weighed_g":null,"from_box":true},{"plane":"2","position_deg":340.0,"hole":"17","mass_g":200.0,"fastener_g":0.0,"weighed_g":null,"from_box":true}]]}','32284965e75e71ca661343d42d86f7f3cce92526d00a434c3a05beadcc60283e');
INSERT INTO "audit" VALUES(34,34,'2026-11-28 12:17:55.062710','local','added','session','ca603b49fb1549698579ba1847fcfd7f','ca603b49fb1549698579ba1847fcfd7f','{"machine_id":"19509a0001c54d398e86978768ef1c43","machine_name":"drum","catalogue_id":"fc224d3023ae4da4a19f8302801bb154","state":"open","created_at":"2026-11-28T12:17:55.061281+00:00"}','2c399343596b03292878d1bd1cf32d711864e4ef4f034ad1c1ebb92ca9416314');
INSERT INTO "audit" VALUES(35,NULL,'2026-11-28 12:17:55.081523','local','sent','reading','bridge',NULL,'{"new":10,"last_sequence":9}',NULL);
INSERT INTO "audit" VALUES(36,NULL,'2026-11-28 12:17:55.085684','local','sent','reading','bridge',NULL,'{"new":10,"last_sequence":29}',NULL);
INSERT INTO "audit" VALUES(37,35,'2026-11-28 12:17:55.097466','local','added','run','ccc4a4f3b8084a069ed2f9888e99abbe','ca603b49fb1549698579ba1847fcfd7f','{"session_id":"ca603b49fb1549698579ba1847fcfd7f","number":1}','5cf24ef914515efc8df2d4545f27ab4f3bbce34de1f56d48b8db95603edff6c1');
INSERT INTO "audit" VALUES(38,36,'2026-11-28 12:17:55.105472','local','added','balancer_answer','c36170cc6f264530874a467c283bd030','ca603b49fb1549698579ba1847fcfd7f','{"source":"balancer","sequence":1,"machine_id":"19509a0001c54d398e86978768ef1c43","session_id":"ca603b49fb1549698579ba1847fcfd7f","taken_at":"2026-11-28T12:17:55.099361+00:00"}','2a6960e05f0b243a785f751bd5f631da9b293fa1523cc7494d0bb63b683f6c29');
CREATE TABLE balancer_answer (
	id VARCHAR(32) NOT NULL, 
	source VARCHAR(100) NOT NULL, 
	sequence BIGINT NOT NULL, 
	machine_id VARCHAR(32) NOT NULL, 
	session_id VARCHAR(32), 
	taken_at DATETIME NOT NULL, 
	masses TEXT NOT NULL, 
	CONSTRAINT pk_balancer_answer PRIMARY KEY (id), 
	CONSTRAINT fk_balancer_answer_machine_id FOREIGN KEY(machine_id) REFERENCES machine (id), 
	CONSTRAINT fk_balancer_answer_session_id FOREIGN KEY(session_id) REFERENCES session (id), 
	CONSTRAINT uq_balancer_answer_source_sequence UNIQUE (source, sequence)
);
INSERT INTO "balancer_answer" VALUES('c36170cc6f264530874a467c283bd030','balancer',1,'19509a0001c54d398e86978768ef1c43','ca603b49fb1549698579ba1847fcfd7f','2026-11-28 12:17:55.099361','[{"plane":"1","mass_g":50.0,"angle_deg":10.0}]');
CREATE TABLE catalogue (
	id VARCHAR(32) NOT NULL, 
	name VARCHAR(100) NOT NULL, 
	items TEXT NOT NULL, 
	created_at DATETIME NOT NULL, 
	CONSTRAINT pk_catalogue PRIMARY KEY (id), 
	CONSTRAINT uq_catalogue_name UNIQUE (name)
);
INSERT INTO "catalogue" VALUES('fc224d3023ae4da4a19f8302801bb154','box','[{"mass_g":10.0,"count":10,"name":null,"fastener_g":0.0},{"mass_g":20.0,"count":10,"name":null,"fastener_g":0.0},{"mass_g":50.0,"count":10,"name":null,"fastener_g":0.0},{"mass_g":100.0,"count":10,"name":null,"fastener_g":0.0},{"mass_g":200.0,"count":10,"name":null,"fastener_g":0.0},{"mass_g":300.0,"count":10,"name":null,"fastener_g":0.0}]','2026-11-28 12:17:54.821037');
CREATE TABLE correction (
	id VARCHAR(32) NOT NULL, 
	session_id VARCHAR(32) NOT NULL, 
	number INTEGER NOT NULL, 
	correction TEXT NOT NULL, 
	CONSTRAINT pk_correction PRIMARY KEY (id), 
	CONSTRAINT fk_correction_session_id FOREIGN KEY(session_id) REFERENCES session (id), 
	CONSTRAINT uq_correction_session_id_number UNIQUE (session_id, number)
);
INSERT INTO "correction" VALUES('aeb2f3a066b64d1082cb91f144fb18dd','126046a2232e4313a381263690aa0a5c',1,'{"id":"aeb2f3a066b64d1082cb91f144fb18dd","number":1,"request":{"source":"fit","method":null,"damping":null,"max_mass_g":null,"planes":null,"mounted_later":null,"earlier_sessions":null,"influence_of":null,"masses":null,"answer_id":null},"runs":[1,2,3],"influence":[[{"sensor":"P","plane":"1","speed_rpm":460.0,"amplitude_per_g":0.013999999999999999,"phase_deg":17.188733853924703,"scatter_per_g":0.00007071067811865475},{"sensor":"P","plane":"2","speed_rpm":460.0,"amplitude_per_g":0.004000000000000003,"phase_deg":68.75493541569875,"scatter_per_g":0.00007071067811865475}],[{"sensor":"Q","plane":"1","speed_rpm":460.0,"amplitude_per_g":0.0029999999999999966,"phase_deg":325.6225322921508,"scatter_per_g":0.00007071067811865475},{"sensor":"Q","plane":"2","speed_rpm":460.0,"amplitude_per_g":0.01700000000000001,"phase_deg":28.64788975654117,"scatter_per_g":0.00007071067811865475}]],"initial":[{"sensor":"P","speed_rpm":460.0,"amplitude":3.109,"phase_deg":40.10704565915762,"scatter":0.010000000000000002,"interval":{"low":3.0893842778130103,"high":3.1285835575038115,"confidence":0.95},"limit":0.7},{"sensor":"Q","speed_rpm":460.0,"amplitude":4.785,"phase_deg":120.3211369774729,"scatter":0.010000000000000002,"interval":{"low":4.765389910833806,"high":4.804589190524606,"confidence":0.95},"limit":0.7}],"corrections":[{"plane":"1","mass_g":285.7972193346176,"angle_deg":187.5107563017048,"unbalance_gmm":94313.0823804238,"interval":{"low":280.34716134218246,"high":291.2203557724063,"confidence":0.95},"angle_interval":{"low":186.42347672540677,"high":188.5980358780028,"confidence":0.95},"ellipse":{"major_g":6.7896214971017805,"minor_g":6.78962149710178,"angle_deg":90.0,"confidence":0.95}},{"plane":"2","mass_g":325.0097245763065,"angle_deg":276.496922558894,"unbalance_gmm":107253.20911018114,"interval":{"low":320.54465035877945,"high":329.4588871224594,"confidence":0.95},"angle_interval":{"low":275.7125577245592,"high":277.28128739322887,"confidence":0.95},"ellipse":{"major_g":5.566376463635999,"minor_g":5.566376463635997,"angle_deg":0.0,"confidence":0.95}}],"trim":[{"plane":"1","mass_g":285.7972193346176,"angle_deg":187.5107563017048,"unbalance_gmm":94313.0823804238,"interval":null,"angle_interval":null,"ellipse":null},{"plane":"2","mass_g":361.8306244290872,"angle_deg":243.18511519433974,"unbalance_gmm":119404.10606159878,"interval":null,"angle_interval":null,"ellipse":null}],"predicted":[{"sensor":"P","speed_rpm":460.0,"amplitude":4.440892098500626e-16,"phase_deg":90.0,"scatter":0.035935286962738164,"interval":{"low":0.0,"high":0.08796048477264799,"confidence":0.95},"limit":0.7},{"sensor":"Q","speed_rpm":460.0,"amplitude":1.9860273225978185e-15,"phase_deg":116.56505117707799,"scatter":0.035935286962738164,"interval":{"low":0.0,"high":0.08796048477264799,"confidence":0.95},"limit":0.7}],"quality":{"condition":1.5757517557434197,"significance":[0.9048260999824493,1.0],"degrees_of_freedom":[0,0],"objective_value":2.0350724194510405e-15,"lower_bound":2.0350724194510405e-15},"static_couple":{"static":[{"plane":"1","mass_g":218.28789347774838,"angle_deg":235.61280913539622,"unbalance_gmm":72035.00484765696,"interval":null,"angle_interval":null,"ellipse":null},{"plane":"2","mass_g":218.28789347774838,"angle_deg":235.61280913539622,"unbalance_gmm":72035.00484765696,"interval":null,"angle_interval":null,"ellipse":null}],"couple":[{"plane":"1","mass_g":214.49028272938205,"angle_deg":138.26521876389668,"unbalance_gmm":70781.79330069608,"interval":null,"angle_interval":null,"ellipse":null},{"plane":"2","mass_g":214.49028272938205,"angle_deg":318.2652187638967,"unbalance_gmm":70781.79330069608,"interval":null,"angle_interval":null,"ellipse":null}],"unbalance_gmm":144070.00969531393,"moment_gmm2":46715983.578459404},"tolerance":null,"alternatives":[],"saved_influence":null,"earlier_runs":[],"diagnostics":[],"stale":true,"tolerance_missing":null}');
INSERT INTO "correction" VALUES('5a0b770d01f64c479797a0a342bd0ff1','245e96a653a44bb290b1d376e645dd4a',1,'{"id":"5a0b770d01f64c479797a0a342bd0ff1","number":1,"request":{"source":"fit","method":null,"damping":null,"max_mass_g":null,"planes":null,"mounted_later":null,"earlier_sessions":null,"influence_of":null,"masses":null,"answer_id":null},"runs":[1,2,3],"influence":[[{"sensor":"P","plane":"1","speed_rpm":460.0,"amplitude_per_g":0.013999999999999999,"phase_deg":17.188733853924703,"scatter_per_g":0.00007071067811865475},{"sensor":"P","plane":"2","speed_rpm":460.0,"amplitude_per_g":0.004000000000000003,"phase_deg":68.75493541569875,"scatter_per_g":0.00007071067811865475}],[{"sensor":"Q","plane":"1","speed_rpm":460.0,"amplitude_per_g":0.0029999999999999966,"phase_deg":325.6225322921508,"scatter_per_g":0.00007071067811865475},{"sensor":"Q","plane":"2","speed_rpm":460.0,"amplitude_per_g":0.01700000000000001,"phase_deg":28.64788975654117,"scatter_per_g":0.00007071067811865475}]],"initial":[{"sensor":"P","speed_rpm":460.0,"amplitude":3.109,"phase_deg":40.10704565915762,"scatter":0.010000000000000002,"interval":{"low":3.0893842778130103,"high":3.1285835575038115,"confidence":0.95},"limit":0.7},{"sensor":"Q","speed_rpm":460.0,"amplitude":4.785,"phase_deg":120.3211369774729,"scatter":0.010000000000000002,"interval":{"low":4.765389910833806,"high":4.804589190524606,"confidence":0.95},"limit":0.7}],"corrections":[{"plane":"1","mass_g":285.7972193346176,"angle_deg":187.5107563017048,"unbalance_gmm":94313.0823804238,"interval":{"low":280.34716134218246,"high":291.2203557724063,"confidence":0.95},"angle_interval":{"low":186.42347672540677,"high":188.5980358780028,"confidence":0.95},"ellipse":{"major_g":6.7896214971017805,"minor_g":6.78962149710178,"angle_deg":90.0,"confidence":0.95}},{"plane":"2","mass_g":325.0097245763065,"angle_deg":276.496922558894,"unbalance_gmm":107253.20911018114,"interval":{"low":320.54465035877945,"high":329.4588871224594,"confidence":0.95},"angle_interval":{"low":275.7125577245592,"high":277.28128739322887,"confidence":0.95},"ellipse":{"major_g":5.566376463635999,"minor_g":5.566376463635997,"angle_deg":0.0,"confidence":0.95}}],"trim":[{"plane":"1","mass_g":285.7972193346176,"angle_deg":187.5107563017048,"unbalance_gmm":94313.0823804238,"interval":null,"angle_interval":null,"ellipse":null},{"plane":"2","mass_g":361.8306244290872,"angle_deg":243.18511519433974,"unbalance_gmm":119404.10606159878,"interval":null,"angle_interval":null,"ellipse":null}],"predicted":[{"sensor":"P","speed_rpm":460.0,"amplitude":4.440892098500626e-16,"phase_deg":90.0,"scatter":0.035935286962738164,"interval":{"low":0.0,"high":0.08796048477264799,"confidence":0.95},"limit":0.7},{"sensor":"Q","speed_rpm":460.0,"amplitude":1.9860273225978185e-15,"phase_deg":116.56505117707799,"scatter":0.035935286962738164,"interval":{"low":0.0,"high":0.08796048477264799,"confidence":0.95},"limit":0.7}],"quality":{"condition":1.5757517557434197,"significance":[0.9048260999824493,1.0],"degrees_of_freedom":[0,0],"objective_value":2.0350724194510405e-15,"lower_bound":2.0350724194510405e-15},"static_couple":{"static":[{"plane":"1","mass_g":218.28789347774838,"angle_deg":235.61280913539622,"unbalance_gmm":72035.00484765696,"interval":null,"angle_interval":null,"ellipse":null},{"plane":"2","mass_g":218.28789347774838,"angle_deg":235.61280913539622,"unbalance_gmm":72035.00484765696,"interval":null,"angle_interval":null,"ellipse":null}],"couple":[{"plane":"1","mass_g":214.49028272938205,"angle_deg":138.26521876389668,"unbalance_gmm":70781.79330069608,"interval":null,"angle_interval":null,"ellipse":null},{"plane":"2","mass_g":214.49028272938205,"angle_deg":318.2652187638967,"unbalance_gmm":70781.79330069608,"interval":null,"angle_interval":null,"ellipse":null}],"unbalance_gmm":144070.00969531393,"moment_gmm2":46715983.578459404},"tolerance":null,"alternatives":[],"saved_influence":null,"earlier_runs":[],"diagnostics":[],"stale":false,"tolerance_missing":null}');
CREATE TABLE idempotency (
	id VARCHAR(64) NOT NULL, 
	request VARCHAR(64) NOT NULL, 
	status INTEGER NOT NULL, 
	body TEXT NOT NULL, 
	expires_at DATETIME NOT NULL, 
	CONSTRAINT pk_idempotency PRIMARY KEY (id)
);
CREATE TABLE influence (
	id VARCHAR(32) NOT NULL, 
	machine_id VARCHAR(32) NOT NULL, 
	session_id VARCHAR(32) NOT NULL, 
	machine_type VARCHAR(100), 
	learned_at DATETIME NOT NULL, 
	learned TEXT NOT NULL, 
	CONSTRAINT pk_influence PRIMARY KEY (id), 
	CONSTRAINT fk_influence_machine_id FOREIGN KEY(machine_id) REFERENCES machine (id), 
	CONSTRAINT fk_influence_session_id FOREIGN KEY(session_id) REFERENCES session (id), 
	CONSTRAINT uq_influence_session_id UNIQUE (session_id)
);
INSERT INTO "influence" VALUES('0dc6a8fa31ff46518396e93123960904','19509a0001c54d398e86978768ef1c43','126046a2232e4313a381263690aa0a5c','T1','2026-11-28 12:17:54.943455','{"id":"0dc6a8fa31ff46518396e93123960904","machine_id":"19509a0001c54d398e86978768ef1c43","session_id":"126046a2232e4313a381263690aa0a5c","learned_at":"2026-11-28T12:17:54.943455Z","saved":{"planes":["1","2"],"rows":[{"sensor":"P","speed_rpm":460.0,"influence":[[0.013374710847758481,0.0041372828932587525],[0.0014494310179066921,0.003728156343868905]],"covariance":[[[1.9359888784374207e-9,-7.07009852029194e-26],[-4.650576162172828e-11,-1.523811139822254e-9]],[[-4.650576162172828e-11,1.5238111398222542e-9],[2.1257637017558102e-9,-2.813965510467528e-26]]]},{"sensor":"Q","speed_rpm":460.0,"influence":[[0.0024760068447290356,-0.001693927420185098],[0.014918903552136337,0.008150234156271457]],"covariance":[[[1.9359888784374207e-9,-7.07009852029194e-26],[-4.650576162172828e-11,-1.523811139822254e-9]],[[-4.650576162172828e-11,1.5238111398222542e-9],[2.1257637017558102e-9,-2.813965510467528e-26]]]}],"sessions":1},"coefficients":[[{"sensor":"P","plane":"1","speed_rpm":460.0,"amplitude_per_g":0.013999999999999997,"phase_deg":17.188733853924692,"scatter_per_g":0.00004399987361842555},{"sensor":"P","plane":"2","speed_rpm":460.0,"amplitude_per_g":0.003999999999999999,"phase_deg":68.75493541569881,"scatter_per_g":0.00004610600505092379}],[{"sensor":"Q","plane":"1","speed_rpm":460.0,"amplitude_per_g":0.002999999999999996,"phase_deg":325.62253229215077,"scatter_per_g":0.00004399987361842555},{"sensor":"Q","plane":"2","speed_rpm":460.0,"amplitude_per_g":0.017000000000000005,"phase_deg":28.647889756541176,"scatter_per_g":0.00004610600505092379}]],"refused":[]}');
CREATE TABLE login (
	id VARCHAR(64) NOT NULL, 
	token_id VARCHAR(32) NOT NULL, 
	created_at DATETIME NOT NULL, 
	expires_at DATETIME NOT NULL, 
	CONSTRAINT pk_login PRIMARY KEY (id), 
	CONSTRAINT fk_login_token_id FOREIGN KEY(token_id) REFERENCES token (id)
);
CREATE TABLE machine (
	id VARCHAR(32) NOT NULL, 
	name VARCHAR(100) NOT NULL, 
	spec TEXT NOT NULL, 
	created_at DATETIME NOT NULL, 
	updated_at DATETIME NOT NULL, 
	CONSTRAINT pk_machine PRIMARY KEY (id), 
	CONSTRAINT uq_machine_name UNIQUE (name)
);
INSERT INTO "machine" VALUES('19509a0001c54d398e86978768ef1c43','drum','{"name":"drum","type":"T1","rotor_mass_kg":120.0,"service_speed_rpm":460.0,"rotation":"ccw","seen_from":null,"balance_grade_mm_s":null,"vibration_limit_mm_s":0.7,"iso_20816":null,"angle_sense":"against_rotation","phase_sense":"lag","bearings":[],"planes":[{"name":"1","radius_mm":330.0,"axial_mm":-330.0,"positions_deg":[20.0,40.0,60.0,80.0,100.0,120.0,140.0,160.0,180.0,200.0,220.0,240.0,260.0,280.0,300.0,320.0,340.0,0.0],"hole_labels":null,"masses_per_position":1,"max_masses":3,"max_total_mass_g":null,"max_force_n":null},{"name":"2","radius_mm":330.0,"axial_mm":330.0,"positions_deg":[20.0,40.0,60.0,80.0,100.0,120.0,140.0,160.0,180.0,200.0,220.0,240.0,260.0,280.0,300.0,320.0,340.0,0.0],"hole_labels":null,"masses_per_position":1,"max_masses":3,"max_total_mass_g":null,"max_force_n":null}],"sensors":[{"name":"P","axial_mm":-480.0,"bearing":null,"direction":null,"quantity":"velocity","unit":"mm/s","detection":"rms","limit":null,"serial":null},{"name":"Q","axial_mm":440.0,"bearing":null,"direction":null,"quantity":"velocity","unit":"mm/s","detection":"rms","limit":null,"serial":null}]}','2026-11-28 12:17:54.806732','2026-11-28 12:17:54.806732');
CREATE TABLE "plan" (
	id VARCHAR(32) NOT NULL, 
	session_id VARCHAR(32) NOT NULL, 
	number INTEGER NOT NULL, 
	"plan" TEXT NOT NULL, 
	CONSTRAINT pk_plan PRIMARY KEY (id), 
	CONSTRAINT fk_plan_session_id FOREIGN KEY(session_id) REFERENCES session (id), 
	CONSTRAINT uq_plan_session_id_number UNIQUE (session_id, number)
);
INSERT INTO "plan" VALUES('c1de695b1a0c4bbdbb3bdb12922b00de','126046a2232e4313a381263690aa0a5c',1,'{"id":"c1de695b1a0c4bbdbb3bdb12922b00de","number":1,"session_id":"126046a2232e4313a381263690aa0a5c","correction_id":"aeb2f3a066b64d1082cb91f144fb18dd","request":{"correction_id":"aeb2f3a066b64d1082cb91f144fb18dd","objective":"residual_vibration","norm":null,"weights":null,"mode":"best","limit":null,"slack":0.0,"alternatives":0,"angle_tolerance_deg":null,"mass_tolerance_g":null,"method":"exact","base":"as_found","max_masses_per_plane":2,"blocked":[],"seed":1,"time_limit_s":10.0},"inputs":{"counts":[10,10,10,10,10,10],"present":[],"present_off":[],"version":"0.1.0","catalogue_id":"fc224d3023ae4da4a19f8302801bb154"},"status":"optimal","message":"proved: no selection within the limits is better","reason":null,"placements":[{"plane":"1","position_deg":160.0,"hole":"8","mass_g":100.0,"fastener_g":0.0,"weighed_g":null,"from_box":true},{"plane":"1","position_deg":200.0,"hole":"10","mass_g":200.0,"fastener_g":0.0,"weighed_g":null,"from_box":true},{"plane":"2","position_deg":240.0,"hole":"12","mass_g":300.0,"fastener_g":0.0,"weighed_g":null,"from_box":true},{"plane":"2","position_deg":340.0,"hole":"17","mass_g":200.0,"fastener_g":0.0,"weighed_g":null,"from_box":true}],"taken_off":[],"changes":[{"action":"add","placement":{"plane":"1","position_deg":160.0,"hole":"8","mass_g":100.0,"fastener_g":0.0,"weighed_g":null,"from_box":true}},{"action":"add","placement":{"plane":"1","position_deg":200.0,"hole":"10","mass_g":200.0,"fastener_g":0.0,"weighed_g":null,"from_box":true}},{"action":"add","placement":{"plane":"2","position_deg":240.0,"hole":"12","mass_g":300.0,"fastener_g":0.0,"weighed_g":null,"from_box":true}},{"action":"add","placement":{"plane":"2","position_deg":340.0,"hole":"17","mass_g":200.0,"fastener_g":0.0,"weighed_g":null,"from_box":true}}],"objective_value":0.21005729811021306,"objective_unit":"1","lower_bound":0.21005729811021306,"gap":0.0,"objective_scatter":0.1026722484649662,"predicted":[{"sensor":"P","speed_rpm":460.0,"amplitude":0.05262318941559279,"phase_deg":58.39686689003718,"scatter":0.03599501236371736,"interval":{"low":0.0,"high":0.114678080784789,"confidence":0.95},"limit":0.7},{"sensor":"Q","speed_rpm":460.0,"amplitude":0.09441691926155633,"phase_deg":317.2862757868095,"scatter":0.03599501236371736,"interval":{"low":0.0,"high":0.15966688235129514,"confidence":0.95},"limit":0.7}],"bearing_forces_n":{"bearings":["P","Q"],"before":[186.08756624902912,222.62770397064367],"after":[1.8497209268464714,3.3152434737386733]},"per_method":[{"method":"exact","status":"optimal","objective_value":0.21005729811021306,"lower_bound":0.21005729811021306,"evaluations":11,"seconds":0.003955621999921277}],"placement_spread":null,"alternatives":[],"evaluations":11,"seconds":0.003968150999753561,"seed":1,"created_at":"2026-11-28T12:17:54.902566Z","state":"fitted","stale":false,"fitted":[{"plane":"1","position_deg":160.0,"hole":"8","mass_g":100.0,"fastener_g":0.0,"weighed_g":null,"from_box":true},{"plane":"1","position_deg":200.0,"hole":"10","mass_g":200.0,"fastener_g":0.0,"weighed_g":null,"from_box":true},{"plane":"2","position_deg":240.0,"hole":"12","mass_g":300.0,"fastener_g":0.0,"weighed_g":null,"from_box":true},{"plane":"2","position_deg":340.0,"hole":"17","mass_g":200.0,"fastener_g":0.0,"weighed_g":null,"from_box":true}],"version":2,"reserved_until":null,"slack_proved":null}');
INSERT INTO "plan" VALUES('49ab8648f46c41c19fd498a90bd0ec43','245e96a653a44bb290b1d376e645dd4a',1,'{"id":"49ab8648f46c41c19fd498a90bd0ec43","number":1,"session_id":"245e96a653a44bb290b1d376e645dd4a","correction_id":"5a0b770d01f64c479797a0a342bd0ff1","request":{"correction_id":"5a0b770d01f64c479797a0a342bd0ff1","objective":"residual_vibration","norm":null,"weights":null,"mode":"best","limit":null,"slack":0.0,"alternatives":0,"angle_tolerance_deg":null,"mass_tolerance_g":null,"method":"exact","base":"as_found","max_masses_per_plane":2,"blocked":[],"seed":1,"time_limit_s":10.0},"inputs":{"counts":[10,10,10,9,8,9],"present":[],"present_off":[],"version":"0.1.0","catalogue_id":"fc224d3023ae4da4a19f8302801bb154"},"status":"optimal","message":"proved: no selection within the limits is better","reason":null,"placements":[{"plane":"1","position_deg":160.0,"hole":"8","mass_g":100.0,"fastener_g":0.0,"weighed_g":null,"from_box":true},{"plane":"1","position_deg":200.0,"hole":"10","mass_g":200.0,"fastener_g":0.0,"weighed_g":null,"from_box":true},{"plane":"2","position_deg":240.0,"hole":"12","mass_g":300.0,"fastener_g":0.0,"weighed_g":null,"from_box":true},{"plane":"2","position_deg":340.0,"hole":"17","mass_g":200.0,"fastener_g":0.0,"weighed_g":null,"from_box":true}],"taken_off":[],"changes":[{"action":"add","placement":{"plane":"1","position_deg":160.0,"hole":"8","mass_g":100.0,"fastener_g":0.0,"weighed_g":null,"from_box":true}},{"action":"add","placement":{"plane":"1","position_deg":200.0,"hole":"10","mass_g":200.0,"fastener_g":0.0,"weighed_g":null,"from_box":true}},{"action":"add","placement":{"plane":"2","position_deg":240.0,"hole":"12","mass_g":300.0,"fastener_g":0.0,"weighed_g":null,"from_box":true}},{"action":"add","placement":{"plane":"2","position_deg":340.0,"hole":"17","mass_g":200.0,"fastener_g":0.0,"weighed_g":null,"from_box":true}}],"objective_value":0.21005729811021306,"objective_unit":"1","lower_bound":0.21005729811021306,"gap":0.0,"objective_scatter":0.1026722484649662,"predicted":[{"sensor":"P","speed_rpm":460.0,"amplitude":0.05262318941559279,"phase_deg":58.39686689003718,"scatter":0.03599501236371736,"interval":{"low":0.0,"high":0.114678080784789,"confidence":0.95},"limit":0.7},{"sensor":"Q","speed_rpm":460.0,"amplitude":0.09441691926155633,"phase_deg":317.2862757868095,"scatter":0.03599501236371736,"interval":{"low":0.0,"high":0.15966688235129514,"confidence":0.95},"limit":0.7}],"bearing_forces_n":{"bearings":["P","Q"],"before":[186.08756624902912,222.62770397064367],"after":[1.8497209268464714,3.3152434737386733]},"per_method":[{"method":"exact","status":"optimal","objective_value":0.21005729811021306,"lower_bound":0.21005729811021306,"evaluations":11,"seconds":0.0035905329996239743}],"placement_spread":null,"alternatives":[],"evaluations":11,"seconds":0.003603322000344633,"seed":1,"created_at":"2026-11-28T12:17:55.022252Z","state":"fitted","stale":false,"fitted":[{"plane":"1","position_deg":160.0,"hole":"8","mass_g":100.0,"fastener_g":0.0,"weighed_g":null,"from_box":true},{"plane":"1","position_deg":200.0,"hole":"10","mass_g":200.0,"fastener_g":0.0,"weighed_g":null,"from_box":true},{"plane":"2","position_deg":240.0,"hole":"12","mass_g":300.0,"fastener_g":0.0,"weighed_g":null,"from_box":true},{"plane":"2","position_deg":340.0,"hole":"17","mass_g":200.0,"fastener_g":0.0,"weighed_g":null,"from_box":true}],"version":2,"reserved_until":null,"slack_proved":null}');
CREATE TABLE reading (
	id INTEGER NOT NULL, 
	source VARCHAR(100) NOT NULL, 
	sequence BIGINT NOT NULL, 
	machine_id VARCHAR(32) NOT NULL, 
	session_id VARCHAR(32), 
	taken_at DATETIME NOT NULL, 
	sensor VARCHAR(100) NOT NULL, 
	amplitude DOUBLE NOT NULL, 
	phase_deg DOUBLE, 
	speed_rpm DOUBLE, 
	scatter DOUBLE, 
	overall_rms DOUBLE, 
	CONSTRAINT pk_reading PRIMARY KEY (id), 
	CONSTRAINT fk_reading_machine_id FOREIGN KEY(machine_id) REFERENCES machine (id), 
	CONSTRAINT fk_reading_session_id FOREIGN KEY(session_id) REFERENCES session (id), 
	CONSTRAINT uq_reading_source_sequence UNIQUE (source, sequence)
);
INSERT INTO "reading" VALUES(1,'bridge',0,'19509a0001c54d398e86978768ef1c43',NULL,'2026-11-28 12:16:55.066902','P',3.1,37.0,NULL,NULL,NULL);
INSERT INTO "reading" VALUES(2,'bridge',1,'19509a0001c54d398e86978768ef1c43',NULL,'2026-11-28 12:16:56.066902','P',3.1,37.0,NULL,NULL,NULL);
INSERT INTO "reading" VALUES(3,'bridge',2,'19509a0001c54d398e86978768ef1c43',NULL,'2026-11-28 12:16:57.066902','P',3.1,37.0,NULL,NULL,NULL);
INSERT INTO "reading" VALUES(4,'bridge',3,'19509a0001c54d398e86978768ef1c43',NULL,'2026-11-28 12:16:58.066902','P',3.1,37.0,NULL,NULL,NULL);
INSERT INTO "reading" VALUES(5,'bridge',4,'19509a0001c54d398e86978768ef1c43',NULL,'2026-11-28 12:16:59.066902','P',3.1,37.0,NULL,NULL,NULL);
INSERT INTO "reading" VALUES(6,'bridge',5,'19509a0001c54d398e86978768ef1c43',NULL,'2026-11-28 12:17:00.066902','P',3.1,37.0,NULL,NULL,NULL);
INSERT INTO "reading" VALUES(7,'bridge',6,'19509a0001c54d398e86978768ef1c43',NULL,'2026-11-28 12:17:01.066902','P',3.1,37.0,NULL,NULL,NULL);
INSERT INTO "reading" VALUES(8,'bridge',7,'19509a0001c54d398e86978768ef1c43',NULL,'2026-11-28 12:17:02.066902','P',3.1,37.0,NULL,NULL,NULL);
INSERT INTO "reading" VALUES(9,'bridge',8,'19509a0001c54d398e86978768ef1c43',NULL,'2026-11-28 12:17:03.066902','P',3.1,37.0,NULL,NULL,NULL);
INSERT INTO "reading" VALUES(10,'bridge',9,'19509a0001c54d398e86978768ef1c43',NULL,'2026-11-28 12:17:04.066902','P',3.1,37.0,NULL,NULL,NULL);
INSERT INTO "reading" VALUES(11,'bridge',20,'19509a0001c54d398e86978768ef1c43',NULL,'2026-11-28 12:16:55.066902','Q',3.1,37.0,NULL,NULL,NULL);
INSERT INTO "reading" VALUES(12,'bridge',21,'19509a0001c54d398e86978768ef1c43',NULL,'2026-11-28 12:16:56.066902','Q',3.1,37.0,NULL,NULL,NULL);
INSERT INTO "reading" VALUES(13,'bridge',22,'19509a0001c54d398e86978768ef1c43',NULL,'2026-11-28 12:16:57.066902','Q',3.1,37.0,NULL,NULL,NULL);
INSERT INTO "reading" VALUES(14,'bridge',23,'19509a0001c54d398e86978768ef1c43',NULL,'2026-11-28 12:16:58.066902','Q',3.1,37.0,NULL,NULL,NULL);
INSERT INTO "reading" VALUES(15,'bridge',24,'19509a0001c54d398e86978768ef1c43',NULL,'2026-11-28 12:16:59.066902','Q',3.1,37.0,NULL,NULL,NULL);
INSERT INTO "reading" VALUES(16,'bridge',25,'19509a0001c54d398e86978768ef1c43',NULL,'2026-11-28 12:17:00.066902','Q',3.1,37.0,NULL,NULL,NULL);
INSERT INTO "reading" VALUES(17,'bridge',26,'19509a0001c54d398e86978768ef1c43',NULL,'2026-11-28 12:17:01.066902','Q',3.1,37.0,NULL,NULL,NULL);
INSERT INTO "reading" VALUES(18,'bridge',27,'19509a0001c54d398e86978768ef1c43',NULL,'2026-11-28 12:17:02.066902','Q',3.1,37.0,NULL,NULL,NULL);
INSERT INTO "reading" VALUES(19,'bridge',28,'19509a0001c54d398e86978768ef1c43',NULL,'2026-11-28 12:17:03.066902','Q',3.1,37.0,NULL,NULL,NULL);
INSERT INTO "reading" VALUES(20,'bridge',29,'19509a0001c54d398e86978768ef1c43',NULL,'2026-11-28 12:17:04.066902','Q',3.1,37.0,NULL,NULL,NULL);
CREATE TABLE reading_findings (
	source VARCHAR(100) NOT NULL, 
	sequence BIGINT NOT NULL, 
	taken_at DATETIME NOT NULL, 
	findings TEXT NOT NULL, 
	CONSTRAINT pk_reading_findings PRIMARY KEY (source, sequence)
);
CREATE TABLE reading_minute (
	id INTEGER NOT NULL, 
	source VARCHAR(100) NOT NULL, 
	machine_id VARCHAR(32) NOT NULL, 
	sensor VARCHAR(100) NOT NULL, 
	minute DATETIME NOT NULL, 
	readings INTEGER NOT NULL, 
	last_sequence BIGINT NOT NULL, 
	amplitude DOUBLE NOT NULL, 
	phase_deg DOUBLE, 
	scatter DOUBLE, 
	speed_rpm DOUBLE, 
	overall_rms DOUBLE, 
	CONSTRAINT pk_reading_minute PRIMARY KEY (id), 
	CONSTRAINT fk_reading_minute_machine_id FOREIGN KEY(machine_id) REFERENCES machine (id)
);
CREATE TABLE run (
	id VARCHAR(32) NOT NULL, 
	session_id VARCHAR(32) NOT NULL, 
	number INTEGER NOT NULL, 
	run TEXT NOT NULL, 
	CONSTRAINT pk_run PRIMARY KEY (id), 
	CONSTRAINT fk_run_session_id FOREIGN KEY(session_id) REFERENCES session (id), 
	CONSTRAINT uq_run_session_id_number UNIQUE (session_id, number)
);
INSERT INTO "run" VALUES('b7a47ec099684045970727bdb064b417','126046a2232e4313a381263690aa0a5c',1,'{"id":"b7a47ec099684045970727bdb064b417","number":1,"kind":"initial","masses":[],"readings":[{"sensor":"P","amplitude":3.1090000000000004,"phase_deg":40.10704565915762,"speed_rpm":null,"scatter":0.01,"overall_rms":null,"findings":null},{"sensor":"Q","amplitude":4.785,"phase_deg":120.32113697747289,"speed_rpm":null,"scatter":0.01,"overall_rms":null,"findings":null}],"nominal_speed_rpm":460.0,"taken_at":"2026-11-28T12:17:54.868148Z","excluded":false,"reason":null,"warnings":[]}');
INSERT INTO "run" VALUES('fe5e163a627e4a4d8e32d84a4b889e6e','126046a2232e4313a381263690aa0a5c',2,'{"id":"fe5e163a627e4a4d8e32d84a4b889e6e","number":2,"kind":"trial","masses":[{"plane":"1","mass_g":200.0,"angle_deg":0.0}],"readings":[{"sensor":"P","amplitude":5.7915387704812815,"phase_deg":29.255221674145943,"speed_rpm":null,"scatter":0.01,"overall_rms":null,"findings":null},{"sensor":"Q","amplitude":4.250299137771133,"phase_deg":116.86228260567829,"speed_rpm":null,"scatter":0.01,"overall_rms":null,"findings":null}],"nominal_speed_rpm":460.0,"taken_at":"2026-11-28T12:17:54.876039Z","excluded":false,"reason":null,"warnings":[{"code":"trial_mass_large","severity":"warning","message":"200 g at 330 mm pull with 153 N at 460 r/min, 27% of the static load of 563 N; a tenth is usual","advice":"Make sure that mass and bearings stand it, or start with a smaller one.","runs":[],"planes":["1"],"sensors":[]}]}');
INSERT INTO "run" VALUES('05b2ab05d47b417d86eac1fe8b46a323','126046a2232e4313a381263690aa0a5c',3,'{"id":"05b2ab05d47b417d86eac1fe8b46a323","number":3,"kind":"trial","masses":[{"plane":"2","mass_g":200.0,"angle_deg":0.0}],"readings":[{"sensor":"P","amplitude":3.8303169184634673,"phase_deg":45.853864496124906,"speed_rpm":null,"scatter":0.01,"overall_rms":null,"findings":null},{"sensor":"Q","amplitude":5.788448060003706,"phase_deg":84.36778922422086,"speed_rpm":null,"scatter":0.01,"overall_rms":null,"findings":null}],"nominal_speed_rpm":460.0,"taken_at":"2026-11-28T12:17:54.883403Z","excluded":false,"reason":null,"warnings":[{"code":"trial_mass_large","severity":"warning","message":"200 g at 330 mm pull with 153 N at 460 r/min, 25% of the static load of 614 N; a tenth is usual","advice":"Make sure that mass and bearings stand it, or start with a smaller one.","runs":[],"planes":["2"],"sensors":[]}]}');
INSERT INTO "run" VALUES('f3dce9bf66f44630946828a992e7ff18','126046a2232e4313a381263690aa0a5c',4,'{"id":"f3dce9bf66f44630946828a992e7ff18","number":4,"kind":"check","masses":[{"plane":"1","mass_g":100.0,"angle_deg":160.0},{"plane":"1","mass_g":200.0,"angle_deg":200.0},{"plane":"2","mass_g":300.0,"angle_deg":240.0},{"plane":"2","mass_g":200.0,"angle_deg":340.0}],"readings":[{"sensor":"P","amplitude":0.052623189415593394,"phase_deg":58.39686689003957,"speed_rpm":null,"scatter":0.01,"overall_rms":null,"findings":null},{"sensor":"Q","amplitude":0.09441691926155006,"phase_deg":-42.713724213187994,"speed_rpm":null,"scatter":0.01,"overall_rms":null,"findings":null}],"nominal_speed_rpm":460.0,"taken_at":"2026-11-28T12:17:54.933132Z","excluded":false,"reason":null,"warnings":[]}');
INSERT INTO "run" VALUES('dfdefcf733374553a0ba0ba14852211e','245e96a653a44bb290b1d376e645dd4a',1,'{"id":"dfdefcf733374553a0ba0ba14852211e","number":1,"kind":"initial","masses":[],"readings":[{"sensor":"P","amplitude":3.1090000000000004,"phase_deg":40.10704565915762,"speed_rpm":null,"scatter":0.01,"overall_rms":null,"findings":null},{"sensor":"Q","amplitude":4.785,"phase_deg":120.32113697747289,"speed_rpm":null,"scatter":0.01,"overall_rms":null,"findings":null}],"nominal_speed_rpm":460.0,"taken_at":"2026-11-28T12:17:54.995561Z","excluded":false,"reason":null,"warnings":[]}');
INSERT INTO "run" VALUES('e88fd431aae94024b595967b842d40a6','245e96a653a44bb290b1d376e645dd4a',2,'{"id":"e88fd431aae94024b595967b842d40a6","number":2,"kind":"trial","masses":[{"plane":"1","mass_g":200.0,"angle_deg":0.0}],"readings":[{"sensor":"P","amplitude":5.7915387704812815,"phase_deg":29.255221674145943,"speed_rpm":null,"scatter":0.01,"overall_rms":null,"findings":null},{"sensor":"Q","amplitude":4.250299137771133,"phase_deg":116.86228260567829,"speed_rpm":null,"scatter":0.01,"overall_rms":null,"findings":null}],"nominal_speed_rpm":460.0,"taken_at":"2026-11-28T12:17:55.002607Z","excluded":false,"reason":null,"warnings":[{"code":"trial_mass_large","severity":"warning","message":"200 g at 330 mm pull with 153 N at 460 r/min, 27% of the static load of 563 N; a tenth is usual","advice":"Make sure that mass and bearings stand it, or start with a smaller one.","runs":[],"planes":["1"],"sensors":[]}]}');
INSERT INTO "run" VALUES('0edd7d4654a4417d99ceed125cd0e6f5','245e96a653a44bb290b1d376e645dd4a',3,'{"id":"0edd7d4654a4417d99ceed125cd0e6f5","number":3,"kind":"trial","masses":[{"plane":"2","mass_g":200.0,"angle_deg":0.0}],"readings":[{"sensor":"P","amplitude":3.8303169184634673,"phase_deg":45.853864496124906,"speed_rpm":null,"scatter":0.01,"overall_rms":null,"findings":null},{"sensor":"Q","amplitude":5.788448060003706,"phase_deg":84.36778922422086,"speed_rpm":null,"scatter":0.01,"overall_rms":null,"findings":null}],"nominal_speed_rpm":460.0,"taken_at":"2026-11-28T12:17:55.008083Z","excluded":false,"reason":null,"warnings":[{"code":"trial_mass_large","severity":"warning","message":"200 g at 330 mm pull with 153 N at 460 r/min, 25% of the static load of 614 N; a tenth is usual","advice":"Make sure that mass and bearings stand it, or start with a smaller one.","runs":[],"planes":["2"],"sensors":[]}]}');
INSERT INTO "run" VALUES('ccc4a4f3b8084a069ed2f9888e99abbe','ca603b49fb1549698579ba1847fcfd7f',1,'{"id":"ccc4a4f3b8084a069ed2f9888e99abbe","number":1,"kind":"initial","masses":[],"readings":[{"sensor":"P","amplitude":3.1,"phase_deg":37.00000000000001,"speed_rpm":null,"scatter":1.0467283057891834e-16,"overall_rms":null,"findings":null},{"sensor":"Q","amplitude":3.1,"phase_deg":37.00000000000001,"speed_rpm":null,"scatter":1.0467283057891834e-16,"overall_rms":null,"findings":null}],"nominal_speed_rpm":460.0,"taken_at":"2026-11-28T12:17:55.096128Z","excluded":false,"reason":null,"warnings":[]}');
CREATE TABLE session (
	id VARCHAR(32) NOT NULL, 
	machine_id VARCHAR(32) NOT NULL, 
	machine_name VARCHAR(100) NOT NULL, 
	machine TEXT NOT NULL, 
	catalogue_id VARCHAR(32), 
	state VARCHAR(16) NOT NULL, 
	technician VARCHAR(100), 
	note TEXT, 
	run_out TEXT NOT NULL, 
	on_rotor TEXT NOT NULL, 
	fitted_plan_id VARCHAR(32), 
	created_at DATETIME NOT NULL, 
	closed_at DATETIME, version INTEGER DEFAULT '1' NOT NULL, 
	CONSTRAINT pk_session PRIMARY KEY (id), 
	CONSTRAINT fk_session_catalogue_id FOREIGN KEY(catalogue_id) REFERENCES catalogue (id), 
	CONSTRAINT fk_session_machine_id FOREIGN KEY(machine_id) REFERENCES machine (id)
);
INSERT INTO "session" VALUES('126046a2232e4313a381263690aa0a5c','19509a0001c54d398e86978768ef1c43','drum','{"name":"drum","type":"T1","rotor_mass_kg":120.0,"service_speed_rpm":460.0,"rotation":"ccw","seen_from":null,"balance_grade_mm_s":null,"vibration_limit_mm_s":0.7,"iso_20816":null,"angle_sense":"against_rotation","phase_sense":"lag","bearings":[],"planes":[{"name":"1","radius_mm":330.0,"axial_mm":-330.0,"positions_deg":[20.0,40.0,60.0,80.0,100.0,120.0,140.0,160.0,180.0,200.0,220.0,240.0,260.0,280.0,300.0,320.0,340.0,0.0],"hole_labels":null,"masses_per_position":1,"max_masses":3,"max_total_mass_g":null,"max_force_n":null},{"name":"2","radius_mm":330.0,"axial_mm":330.0,"positions_deg":[20.0,40.0,60.0,80.0,100.0,120.0,140.0,160.0,180.0,200.0,220.0,240.0,260.0,280.0,300.0,320.0,340.0,0.0],"hole_labels":null,"masses_per_position":1,"max_masses":3,"max_total_mass_g":null,"max_force_n":null}],"sensors":[{"name":"P","axial_mm":-480.0,"bearing":null,"direction":null,"quantity":"velocity","unit":"mm/s","detection":"rms","limit":null,"serial":null},{"name":"Q","axial_mm":440.0,"bearing":null,"direction":null,"quantity":"velocity","unit":"mm/s","detection":"rms","limit":null,"serial":null}]}','fc224d3023ae4da4a19f8302801bb154','closed',NULL,'for later','[]','[]','c1de695b1a0c4bbdbb3bdb12922b00de','2026-11-28 12:17:54.853450','2026-11-28 12:17:54.948785',13);
INSERT INTO "session" VALUES('245e96a653a44bb290b1d376e645dd4a','19509a0001c54d398e86978768ef1c43','drum','{"name":"drum","type":"T1","rotor_mass_kg":120.0,"service_speed_rpm":460.0,"rotation":"ccw","seen_from":null,"balance_grade_mm_s":null,"vibration_limit_mm_s":0.7,"iso_20816":null,"angle_sense":"against_rotation","phase_sense":"lag","bearings":[],"planes":[{"name":"1","radius_mm":330.0,"axial_mm":-330.0,"positions_deg":[20.0,40.0,60.0,80.0,100.0,120.0,140.0,160.0,180.0,200.0,220.0,240.0,260.0,280.0,300.0,320.0,340.0,0.0],"hole_labels":null,"masses_per_position":1,"max_masses":3,"max_total_mass_g":null,"max_force_n":null},{"name":"2","radius_mm":330.0,"axial_mm":330.0,"positions_deg":[20.0,40.0,60.0,80.0,100.0,120.0,140.0,160.0,180.0,200.0,220.0,240.0,260.0,280.0,300.0,320.0,340.0,0.0],"hole_labels":null,"masses_per_position":1,"max_masses":3,"max_total_mass_g":null,"max_force_n":null}],"sensors":[{"name":"P","axial_mm":-480.0,"bearing":null,"direction":null,"quantity":"velocity","unit":"mm/s","detection":"rms","limit":null,"serial":null},{"name":"Q","axial_mm":440.0,"bearing":null,"direction":null,"quantity":"velocity","unit":"mm/s","detection":"rms","limit":null,"serial":null}]}','fc224d3023ae4da4a19f8302801bb154','fitted',NULL,'for later','[]','[]','49ab8648f46c41c19fd498a90bd0ec43','2026-11-28 12:17:54.979167',NULL,9);
INSERT INTO "session" VALUES('ca603b49fb1549698579ba1847fcfd7f','19509a0001c54d398e86978768ef1c43','drum','{"name":"drum","type":"T1","rotor_mass_kg":120.0,"service_speed_rpm":460.0,"rotation":"ccw","seen_from":null,"balance_grade_mm_s":null,"vibration_limit_mm_s":0.7,"iso_20816":null,"angle_sense":"against_rotation","phase_sense":"lag","bearings":[],"planes":[{"name":"1","radius_mm":330.0,"axial_mm":-330.0,"positions_deg":[20.0,40.0,60.0,80.0,100.0,120.0,140.0,160.0,180.0,200.0,220.0,240.0,260.0,280.0,300.0,320.0,340.0,0.0],"hole_labels":null,"masses_per_position":1,"max_masses":3,"max_total_mass_g":null,"max_force_n":null},{"name":"2","radius_mm":330.0,"axial_mm":330.0,"positions_deg":[20.0,40.0,60.0,80.0,100.0,120.0,140.0,160.0,180.0,200.0,220.0,240.0,260.0,280.0,300.0,320.0,340.0,0.0],"hole_labels":null,"masses_per_position":1,"max_masses":3,"max_total_mass_g":null,"max_force_n":null}],"sensors":[{"name":"P","axial_mm":-480.0,"bearing":null,"direction":null,"quantity":"velocity","unit":"mm/s","detection":"rms","limit":null,"serial":null},{"name":"Q","axial_mm":440.0,"bearing":null,"direction":null,"quantity":"velocity","unit":"mm/s","detection":"rms","limit":null,"serial":null}]}','fc224d3023ae4da4a19f8302801bb154','open',NULL,NULL,'[]','[]',NULL,'2026-11-28 12:17:55.061281',NULL,2);
CREATE TABLE source (
	name VARCHAR(100) NOT NULL, 
	machine_id VARCHAR(32) NOT NULL, 
	bound_at DATETIME NOT NULL, 
	CONSTRAINT pk_source PRIMARY KEY (name), 
	CONSTRAINT fk_source_machine_id FOREIGN KEY(machine_id) REFERENCES machine (id)
);
INSERT INTO "source" VALUES('bridge','19509a0001c54d398e86978768ef1c43','2026-11-28 12:17:54.837897');
INSERT INTO "source" VALUES('balancer','19509a0001c54d398e86978768ef1c43','2026-11-28 12:17:54.844159');
CREATE TABLE source_mark (
	source VARCHAR(100) NOT NULL, 
	number BIGINT NOT NULL, 
	counters TEXT NOT NULL, 
	CONSTRAINT pk_source_mark PRIMARY KEY (source)
);
CREATE TABLE stock_balance (
	catalogue_id VARCHAR(32) NOT NULL, 
	item INTEGER NOT NULL, 
	on_hand INTEGER NOT NULL, 
	CONSTRAINT pk_stock_balance PRIMARY KEY (catalogue_id, item), 
	CONSTRAINT ck_stock_balance_on_hand CHECK (on_hand >= 0), 
	CONSTRAINT fk_stock_balance_catalogue_id FOREIGN KEY(catalogue_id) REFERENCES catalogue (id)
);
INSERT INTO "stock_balance" VALUES('fc224d3023ae4da4a19f8302801bb154',0,10);
INSERT INTO "stock_balance" VALUES('fc224d3023ae4da4a19f8302801bb154',1,10);
INSERT INTO "stock_balance" VALUES('fc224d3023ae4da4a19f8302801bb154',2,10);
INSERT INTO "stock_balance" VALUES('fc224d3023ae4da4a19f8302801bb154',3,8);
INSERT INTO "stock_balance" VALUES('fc224d3023ae4da4a19f8302801bb154',4,6);
INSERT INTO "stock_balance" VALUES('fc224d3023ae4da4a19f8302801bb154',5,8);
CREATE TABLE stock_entry (
	id INTEGER NOT NULL, 
	catalogue_id VARCHAR(32) NOT NULL, 
	item INTEGER NOT NULL, 
	kind VARCHAR(16) NOT NULL, 
	pieces INTEGER NOT NULL, 
	session_id VARCHAR(32), 
	plan_id VARCHAR(32), 
	at DATETIME NOT NULL, held INTEGER DEFAULT '0' NOT NULL, until DATETIME, note TEXT, 
	CONSTRAINT pk_stock_entry PRIMARY KEY (id), 
	CONSTRAINT fk_stock_entry_catalogue_id FOREIGN KEY(catalogue_id) REFERENCES catalogue (id), 
	CONSTRAINT fk_stock_entry_plan_id FOREIGN KEY(plan_id) REFERENCES "plan" (id), 
	CONSTRAINT fk_stock_entry_session_id FOREIGN KEY(session_id) REFERENCES session (id)
);
INSERT INTO "stock_entry" VALUES(1,'fc224d3023ae4da4a19f8302801bb154',0,'received',10,NULL,NULL,'2026-11-28 12:17:54.821037',0,NULL,NULL);
INSERT INTO "stock_entry" VALUES(2,'fc224d3023ae4da4a19f8302801bb154',1,'received',10,NULL,NULL,'2026-11-28 12:17:54.821037',0,NULL,NULL);
INSERT INTO "stock_entry" VALUES(3,'fc224d3023ae4da4a19f8302801bb154',2,'received',10,NULL,NULL,'2026-11-28 12:17:54.821037',0,NULL,NULL);
INSERT INTO "stock_entry" VALUES(4,'fc224d3023ae4da4a19f8302801bb154',3,'received',10,NULL,NULL,'2026-11-28 12:17:54.821037',0,NULL,NULL);
INSERT INTO "stock_entry" VALUES(5,'fc224d3023ae4da4a19f8302801bb154',4,'received',10,NULL,NULL,'2026-11-28 12:17:54.821037',0,NULL,NULL);
INSERT INTO "stock_entry" VALUES(6,'fc224d3023ae4da4a19f8302801bb154',5,'received',10,NULL,NULL,'2026-11-28 12:17:54.821037',0,NULL,NULL);
INSERT INTO "stock_entry" VALUES(7,'fc224d3023ae4da4a19f8302801bb154',3,'fitted',-1,'126046a2232e4313a381263690aa0a5c','c1de695b1a0c4bbdbb3bdb12922b00de','2026-11-28 12:17:54.922634',0,NULL,NULL);
INSERT INTO "stock_entry" VALUES(8,'fc224d3023ae4da4a19f8302801bb154',4,'fitted',-2,'126046a2232e4313a381263690aa0a5c','c1de695b1a0c4bbdbb3bdb12922b00de','2026-11-28 12:17:54.922634',0,NULL,NULL);
INSERT INTO "stock_entry" VALUES(9,'fc224d3023ae4da4a19f8302801bb154',5,'fitted',-1,'126046a2232e4313a381263690aa0a5c','c1de695b1a0c4bbdbb3bdb12922b00de','2026-11-28 12:17:54.922634',0,NULL,NULL);
INSERT INTO "stock_entry" VALUES(10,'fc224d3023ae4da4a19f8302801bb154',3,'fitted',-1,'245e96a653a44bb290b1d376e645dd4a','49ab8648f46c41c19fd498a90bd0ec43','2026-11-28 12:17:55.044999',0,NULL,NULL);
INSERT INTO "stock_entry" VALUES(11,'fc224d3023ae4da4a19f8302801bb154',4,'fitted',-2,'245e96a653a44bb290b1d376e645dd4a','49ab8648f46c41c19fd498a90bd0ec43','2026-11-28 12:17:55.044999',0,NULL,NULL);
INSERT INTO "stock_entry" VALUES(12,'fc224d3023ae4da4a19f8302801bb154',5,'fitted',-1,'245e96a653a44bb290b1d376e645dd4a','49ab8648f46c41c19fd498a90bd0ec43','2026-11-28 12:17:55.044999',0,NULL,NULL);
CREATE TABLE stop (
	id VARCHAR(32) NOT NULL, 
	session_id VARCHAR(32) NOT NULL, 
	number INTEGER NOT NULL, 
	stop TEXT NOT NULL, 
	CONSTRAINT pk_stop PRIMARY KEY (id), 
	CONSTRAINT fk_stop_session_id_session FOREIGN KEY(session_id) REFERENCES session (id), 
	CONSTRAINT uq_stop_session_id_number UNIQUE (session_id, number)
);
CREATE TABLE token (
	id VARCHAR(32) NOT NULL, 
	name VARCHAR(100) NOT NULL, 
	scopes TEXT NOT NULL, 
	digest VARCHAR(64) NOT NULL, 
	created_at DATETIME NOT NULL, 
	expires_at DATETIME, 
	revoked_at DATETIME, 
	CONSTRAINT pk_token PRIMARY KEY (id), 
	CONSTRAINT uq_token_name UNIQUE (name)
);
CREATE INDEX ix_catalogue_created_at ON catalogue (created_at);
CREATE INDEX ix_machine_created_at ON machine (created_at);
CREATE INDEX ix_session_created_at ON session (created_at);
CREATE INDEX ix_session_machine_id_created_at ON session (machine_id, created_at);
CREATE INDEX ix_balancer_answer_session_id_taken_at ON balancer_answer (session_id, taken_at);
CREATE INDEX ix_influence_machine_id_learned_at ON influence (machine_id, learned_at);
CREATE INDEX ix_reading_session_id_taken_at ON reading (session_id, taken_at);
CREATE INDEX ix_reading_source_taken_at ON reading (source, taken_at);
CREATE INDEX ix_login_expires_at ON login (expires_at);
CREATE INDEX ix_stock_entry_catalogue_id_id ON stock_entry (catalogue_id, id);
CREATE INDEX ix_stock_entry_catalogue_id_item_id ON stock_entry (catalogue_id, item, id);
CREATE INDEX ix_stock_entry_catalogue_id_until ON stock_entry (catalogue_id, until);
CREATE INDEX ix_stock_entry_plan_id ON stock_entry (plan_id);
CREATE INDEX ix_stock_entry_session_id ON stock_entry (session_id);
CREATE INDEX ix_audit_actor_id ON audit (actor, id);
CREATE INDEX ix_audit_kind_key_id ON audit (kind, "key", id);
CREATE INDEX ix_audit_session_id_id ON audit (session_id, id);
CREATE INDEX ix_reading_minute_source_last_sequence ON reading_minute (source, last_sequence);
CREATE INDEX ix_reading_minute_source_minute ON reading_minute (source, minute);
CREATE INDEX ix_session_not_closed ON session (machine_id, created_at) WHERE state <> 'closed';
CREATE INDEX ix_idempotency_expires_at ON idempotency (expires_at);
CREATE INDEX ix_reading_findings_source_taken_at ON reading_findings (source, taken_at);
CREATE INDEX ix_session_state_created_at ON session (state, created_at);
CREATE INDEX ix_influence_machine_type_machine_id_learned_at ON influence (machine_type, machine_id, learned_at);
CREATE INDEX ix_audit_kind_id ON audit (kind, id);
CREATE INDEX ix_balancer_answer_machine_id_taken_at ON balancer_answer (machine_id, taken_at);
COMMIT;
